#include "libs/authentication/signature.hpp"

#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

using testing::HasSubstr;

std::vector<std::uint8_t> bytes(const std::string& text) { return {text.begin(), text.end()}; }
const SigningKey& key() {
  static const SigningKey kKey(bytes("0123456789abcdef"));
  return kKey;
}

// python3: hmac.new(b"0123456789abcdef", b"PM_ORDERS\0hello", hashlib.sha256).hexdigest()
TEST(Signature, IsTheOneThatPythonComputes) {
  const auto message = key().sign("PM_ORDERS", bytes("hello"));
  ASSERT_EQ(message.size(), 5 + kSignatureBytes);
  EXPECT_EQ(std::string(message.begin(), message.begin() + 13), "helloFSHMAC01");
  std::string hex;
  for (std::size_t i = 13; i < message.size(); ++i) {
    char text[3];
    std::snprintf(text, sizeof text, "%02x", message[i]);
    hex += text;
  }
  EXPECT_EQ(hex, "62aa95ad08a9c995cfaeee9e6b16af37629ad69acd4536aa88c91b92657ffacf");
  EXPECT_EQ(key().verify("PM_ORDERS", message.data(), message.size()), 5U);
  EXPECT_EQ(size_without_signature(message.data(), message.size()), 5U);
}

TEST(Signature, EveryOtherBitIsRefused) {
  const auto good = key().sign("PM_ORDERS", bytes("hello"));
  for (std::size_t i = 0; i < 8 * good.size(); ++i) {
    auto forged = good;
    forged[i / 8] ^= static_cast<std::uint8_t>(1U << (i % 8));
    EXPECT_FALSE(key().verify("PM_ORDERS", forged.data(), forged.size())) << i;
  }
  for (std::size_t size = 0; size < good.size(); ++size)
    EXPECT_FALSE(key().verify("PM_ORDERS", good.data(), size)) << size;
  EXPECT_FALSE(key().verify("COMMAND", good.data(), good.size())) << "of another channel";
  const SigningKey other(bytes("0123456789abcdeF"));
  EXPECT_FALSE(other.verify("PM_ORDERS", good.data(), good.size()));
}

TEST(Signature, KeysComeFromPrivateFiles) {
  const std::string file = testing::TempDir() + "/signature_test.key";
  const auto write = [&](const std::string& text, const std::filesystem::perms mode) {
    std::ofstream(file) << text;
    std::filesystem::permissions(file, mode);
  };
  const auto problem = [&]() -> std::string {
    try {
      load_signing_key(file);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  };
  using std::filesystem::perms;
  write("0123456789abcdef\n", perms::owner_read | perms::owner_write);
  EXPECT_EQ(load_signing_key(file).sign("PM_ORDERS", bytes("hello")),
            key().sign("PM_ORDERS", bytes("hello")));
  write("0123456789abcdef\n", perms::owner_read | perms::owner_write | perms::others_read);
  EXPECT_THAT(problem(), HasSubstr("chmod 600"));
  write("short\n", perms::owner_read | perms::owner_write);
  EXPECT_THAT(problem(), HasSubstr("openssl rand"));
  std::filesystem::remove(file);
  EXPECT_THAT(problem(), HasSubstr(file));
  EXPECT_THROW(SigningKey(bytes("short")), std::invalid_argument);
}

}  // namespace
}  // namespace fusion_slam
