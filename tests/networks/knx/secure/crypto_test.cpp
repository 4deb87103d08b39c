#include "networks/knx/secure/crypto.h"

#include <gtest/gtest.h>

#include <set>

#include "networks/knx/secure/vectors.h"

// Vectors: knx.md, section 18.

namespace rubicon::networks::knx::secure {
namespace {

constexpr std::string_view kClientPublic = "07a37cbc142093c8b755dc1b10e86cb426374ad16aa853ed0bdfc0b2b86d1c7c";
constexpr std::string_view kServerPublic = "5869aff450549732cbaaed5e5df9b30a6da31cb0e5742bad5ad4a1a768f1a67b";
constexpr std::string_view kSharedSecret = "a84dc7c3c8f058b1b2dc4cd1e9b5dc0a7987f88b6a9564cde3391fc421159e77";
constexpr std::string_view kSessionKey = "55e832a7ed7d0f03b46e908d9cca795d";

TEST(SecureCrypto, BothEndsComputeTheSharedSecret) {
  const auto client = KeyPair::of(counting(0x01)).value(), server = KeyPair::of(counting(0x21)).value();
  EXPECT_EQ(base::to_hex(client.public_key()), kClientPublic);
  EXPECT_EQ(base::to_hex(server.public_key()), kServerPublic);
  EXPECT_EQ(base::to_hex(client.shared_with(server.public_key())->view()), kSharedSecret);
  EXPECT_EQ(base::to_hex(server.shared_with(client.public_key())->view()), kSharedSecret);
}

TEST(SecureCrypto, APublicKeyThatGivesZerosIsRefused) {
  const auto client = KeyPair::of(counting(0x01)).value();
  PublicKey order_one{};
  for (const auto first : {std::uint8_t{0}, std::uint8_t{1}}) {
    order_one[0] = first;
    const auto shared = client.shared_with(order_one);
    ASSERT_FALSE(shared);
    EXPECT_EQ(shared.error().code, ErrorCode::kInvalid);
  }
}

TEST(SecureCrypto, APrivateKeyOfAnotherLengthIsAnError) {
  EXPECT_FALSE(KeyPair::of(counting(1, 31)));
}

TEST(SecureCrypto, KeyPairsComeFromTheRandomGenerator) {
  const Random known = [](std::span<std::uint8_t> bytes) -> Result<void> {
    std::uint8_t next = 1;
    for (auto& byte : bytes) byte = next++;
    return {};
  };
  EXPECT_EQ(base::to_hex(KeyPair::make(known)->public_key()), kClientPublic);
  const Random broken = [](std::span<std::uint8_t>) -> Result<void> { return fail(ErrorCode::kIo, "no entropy"); };
  EXPECT_EQ(KeyPair::make(broken).error().text, "no entropy");
  std::set<PublicKey> made;
  for (int i = 0; i < 10; ++i) made.insert(KeyPair::make(system_random())->public_key());
  EXPECT_EQ(made.size(), 10U);
}

TEST(SecureCrypto, TheSessionKeyIsTheBeginningOfADigest) {
  const auto digest = sha256(hex(kSharedSecret)).value();
  EXPECT_EQ(base::to_hex(ByteView(digest).first(Key::kSize)), kSessionKey);
}

TEST(SecureCrypto, MacsOfTheHandshake) {
  Ccm ccm;
  const Block zero{}, counter = array_of<Block>("0000000000000000000000000000ff00");
  const auto device = key_of("e158e4012047bd6cc41aafbc5c04c1fc");
  const auto header =
      hex("0610095200380001"
          "5fcad348447404fa7cff31454d11dfbe4b9456618fdc7840510b6115d09cba07");
  EXPECT_EQ(base::to_hex(ccm.mac(device, zero, header, {}).value()), "b8333c0f752176dd01ddc73866e68ad7");
  Block sent{};
  ASSERT_TRUE(ccm.seal(device, {zero, counter}, header, {}, sent));
  EXPECT_EQ(base::to_hex(sent), "cb2caafaa6eb7d18b8a361a7b39bbaf7");
  EXPECT_TRUE(ccm.open(device, {zero, counter}, header, {}, sent).value());
}

struct Wrapped {
  Nonce nonce;
  Bytes associated, content;
  Key key = key_of(kSessionKey);
};

Wrapped keep_alive() {
  return {{array_of<Block>("00000000000200fa1234567800000008"), array_of<Block>("00000000000200fa123456780000ff00")},
          hex("06100950002e0001"),
          hex("0610095400080400")};
}

TEST(SecureCrypto, SealAndOpenAWrapper) {
  Ccm ccm;
  auto frame = keep_alive();
  Block mac{};
  ASSERT_TRUE(ccm.seal(frame.key, frame.nonce, frame.associated, frame.content, mac));
  EXPECT_EQ(base::to_hex(frame.content), "db38a0ab22281b50");
  EXPECT_EQ(base::to_hex(mac), "52794b7fbdb69eb924d36cf811a836ad");
  EXPECT_TRUE(ccm.open(frame.key, frame.nonce, frame.associated, frame.content, mac).value());
  EXPECT_EQ(base::to_hex(frame.content), "0610095400080400");
}

TEST(SecureCrypto, EveryChangedBitIsFoundAndNothingOfTheContentIsGiven) {
  Ccm ccm;
  auto frame = keep_alive();
  Block mac{};
  ASSERT_TRUE(ccm.seal(frame.key, frame.nonce, frame.associated, frame.content, mac));
  const auto opens = [&](Wrapped changed, const Block& with) {
    const bool opened = ccm.open(changed.key, changed.nonce, changed.associated, changed.content, with).value();
    EXPECT_TRUE(opened || changed.content == Bytes(8));
    return opened;
  };
  EXPECT_TRUE(opens(frame, mac));
  for (unsigned bit = 0; bit < 64; ++bit) {
    const auto flip = [bit](auto& bytes) {
      bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] ^ 1U << bit % 8);
    };
    auto changed = frame;
    flip(changed.content);
    EXPECT_FALSE(opens(changed, mac)) << bit;
    changed = frame;
    flip(changed.associated);
    EXPECT_FALSE(opens(changed, mac)) << bit;
    auto other = mac;
    flip(other);
    EXPECT_FALSE(opens(frame, other)) << bit;
  }
}

TEST(SecureCrypto, AShortMacTakesTheFirstBytesOfTheKeyStream) {
  Ccm ccm;
  const auto key = Key(counting(0x30, 16).view());
  const Nonce nonce{array_of<Block>("000000000005710b0a07008003f10004"),
                    array_of<Block>("000000000005710b0a07000000000100")};
  auto content = hex("00800c33");
  std::array<std::uint8_t, 4> mac{};
  ASSERT_TRUE(ccm.seal(key, nonce, hex("10"), content, mac));
  EXPECT_EQ(base::to_hex(content) + base::to_hex(mac),
            "b24fc876"
            "4c872131");
  EXPECT_TRUE(ccm.open(key, nonce, hex("10"), content, mac).value());
  EXPECT_EQ(base::to_hex(content), "00800c33");
}

TEST(SecureCrypto, ContentsOfAnyLengthSurvive) {
  Ccm ccm;
  for (std::size_t size = 0; size <= 70; ++size) {
    auto frame = keep_alive();
    frame.content.assign(size, 0x5a);
    Block mac{};
    ASSERT_TRUE(ccm.seal(frame.key, frame.nonce, frame.associated, frame.content, mac));
    ASSERT_TRUE(ccm.open(frame.key, frame.nonce, frame.associated, frame.content, mac).value()) << size;
    EXPECT_EQ(frame.content, Bytes(size, 0x5a));
  }
}

// NIST SP 800-38A, F.2.1.
TEST(SecureCrypto, CbcOfWholeBlocks) {
  const auto key = key_of("2b7e151628aed2a6abf7158809cf4f3c");
  const auto start = array_of<Block>("000102030405060708090a0b0c0d0e0f");
  const auto content = hex("6bc1bee22e409f96e93d7e117393172aae2d8a571e03ac9c9eb76fac45af8e51");
  const auto encrypted = hex("7649abac8119b246cee98e9b12e9197d5086cb9b507219ee95db113a917678b2");
  EXPECT_EQ(encrypt_cbc(key, start, content).value(), encrypted);
  EXPECT_EQ(base::to_hex(decrypt_cbc(key, start, encrypted)->view()), base::to_hex(content));
  EXPECT_TRUE(decrypt_cbc(key, start, {})->empty());
  EXPECT_EQ(decrypt_cbc(key, start, ByteView(encrypted).first(31)).error().code, ErrorCode::kInvalid);
}

TEST(SecureCrypto, ComparesBytes) {
  EXPECT_TRUE(equal(hex("0102"), hex("0102")));
  EXPECT_FALSE(equal(hex("0102"), hex("0103")));
  EXPECT_FALSE(equal(hex("0102"), hex("010203")));
  EXPECT_TRUE(equal({}, {}));
}

}  // namespace
}  // namespace rubicon::networks::knx::secure
