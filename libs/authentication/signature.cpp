#include "libs/authentication/signature.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include <openssl/crypto.h>
#include <openssl/evp.h>
#include <openssl/hmac.h>
#include <sys/stat.h>

namespace fusion_slam {
namespace {

constexpr std::array<std::uint8_t, 8> kMark{'F', 'S', 'H', 'M', 'A', 'C', '0', '1'};
constexpr std::size_t kDigestBytes = 32;
static_assert(kMark.size() + kDigestBytes == kSignatureBytes);
constexpr std::size_t kShortestKey_bytes = 16;
constexpr std::size_t kLongestKey_bytes = 4096;

std::array<std::uint8_t, kDigestBytes> digest(const std::vector<std::uint8_t>& key,
                                              const std::string& channel,
                                              const std::uint8_t* message, std::size_t size_bytes) {
  std::vector<std::uint8_t> text(channel.begin(), channel.end());
  text.push_back(0);
  text.insert(text.end(), message, message + size_bytes);
  std::array<std::uint8_t, kDigestBytes> result{};
  unsigned length = 0;
  if (HMAC(EVP_sha256(), key.data(), static_cast<int>(key.size()), text.data(), text.size(),
           result.data(), &length) == nullptr)
    throw std::runtime_error("OpenSSL could not compute an HMAC");
  return result;
}

}  // namespace

SigningKey::SigningKey(std::vector<std::uint8_t> key) : key_(std::move(key)) {
  if (key_.size() < kShortestKey_bytes)
    throw std::invalid_argument(
        "a signing key needs at least 16 bytes: make one with `openssl rand -hex 32`");
}

std::vector<std::uint8_t> SigningKey::sign(const std::string& channel,
                                           const std::vector<std::uint8_t>& message) const {
  const auto mac = digest(key_, channel, message.data(), message.size());
  std::vector<std::uint8_t> result = message;
  result.insert(result.end(), kMark.begin(), kMark.end());
  result.insert(result.end(), mac.begin(), mac.end());
  return result;
}

std::optional<std::size_t> SigningKey::verify(const std::string& channel, const std::uint8_t* bytes,
                                              std::size_t size_bytes) const {
  const std::size_t message_bytes = size_without_signature(bytes, size_bytes);
  if (message_bytes == size_bytes) return std::nullopt;
  const auto expected = digest(key_, channel, bytes, message_bytes);
  const bool same =
      CRYPTO_memcmp(expected.data(), bytes + message_bytes + kMark.size(), kDigestBytes) == 0;
  return same ? std::optional<std::size_t>(message_bytes) : std::nullopt;
}

std::size_t size_without_signature(const std::uint8_t* bytes, std::size_t size_bytes) {
  if (size_bytes < kSignatureBytes) return size_bytes;
  const std::size_t message_bytes = size_bytes - kSignatureBytes;
  return std::equal(kMark.begin(), kMark.end(), bytes + message_bytes) ? message_bytes : size_bytes;
}

SigningKey load_signing_key(const std::filesystem::path& file) {
  struct stat about {};
  if (stat(file.c_str(), &about) != 0)
    throw std::runtime_error("cannot read the key " + file.string() + ": " + std::strerror(errno));
  if ((about.st_mode & 077) != 0)
    throw std::runtime_error("others can read the key " + file.string() + ": chmod 600 " +
                             file.string());
  std::ifstream in(file, std::ios::binary);
  if (!in) throw std::runtime_error("cannot read the key " + file.string());
  std::vector<std::uint8_t> key(kLongestKey_bytes + 1);
  in.read(reinterpret_cast<char*>(key.data()), static_cast<std::streamsize>(key.size()));
  key.resize(static_cast<std::size_t>(in.gcount()));
  if (key.size() > kLongestKey_bytes)
    throw std::runtime_error(file.string() + " is longer than 4096 bytes: that is no key");
  while (!key.empty() && (key.back() == '\n' || key.back() == '\r')) key.pop_back();
  if (key.size() < kShortestKey_bytes)
    throw std::runtime_error("the key " + file.string() +
                             " is shorter than 16 bytes: make one with `openssl rand -hex 32`");
  return SigningKey(std::move(key));
}

}  // namespace fusion_slam
