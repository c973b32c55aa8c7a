// Signed messages: who does not know the key can't give orders. HMAC-SHA256 (RFC 2104, FIPS 180-4)
// by OpenSSL. The signature is appended to the encoded message: LCM's generated decoders stop where
// the message ends, so programs that know nothing of signatures read signed messages all the same.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace fusion_slam {

// On the wire, behind the message: 8 bytes "FSHMAC01", 32 bytes HMAC-SHA256 of
// channel, one zero byte, message.
constexpr std::size_t kSignatureBytes = 40;

class SigningKey {
 public:
  // Throws std::invalid_argument below 16 bytes.
  explicit SigningKey(std::vector<std::uint8_t> key);

  // The message and its signature.
  std::vector<std::uint8_t> sign(const std::string& channel,
                                 const std::vector<std::uint8_t>& message) const;

  // Size of the message alone when its signature is good; else nothing. Takes the same time
  // whatever is wrong with the signature.
  std::optional<std::size_t> verify(const std::string& channel, const std::uint8_t* bytes,
                                    std::size_t size_bytes) const;

 private:
  std::vector<std::uint8_t> key_;
};

// The message alone, whether signed or not: for listeners without a key.
std::size_t size_without_signature(const std::uint8_t* bytes, std::size_t size_bytes);

// The bytes of the file, without a newline at the end. Throws std::runtime_error naming the file:
// unreadable, readable for others than its owner, shorter than 16 bytes, longer than 4096.
SigningKey load_signing_key(const std::filesystem::path& file);

}  // namespace fusion_slam
