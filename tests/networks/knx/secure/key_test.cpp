#include "networks/knx/secure/key.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <sstream>
#include <type_traits>
#include <utility>

#include "networks/knx/secure/crypto.h"
#include "networks/knx/secure/passwords.h"
#include "networks/knx/secure/vectors.h"

namespace rubicon::networks::knx::secure {
namespace {

template <class T, class = void>
struct HasOutput : std::false_type {};
template <class T>
struct HasOutput<T, std::void_t<decltype(std::declval<std::ostream&>() << std::declval<const T&>())>> : std::true_type {
};

TEST(SecureKey, HasNoOutputAndNoConversionToText) {
  EXPECT_FALSE(HasOutput<Key>::value);
  EXPECT_FALSE(HasOutput<Secret>::value);
  EXPECT_FALSE((std::is_convertible_v<Key, std::string>));
  EXPECT_FALSE((std::is_convertible_v<Secret, std::string>));
  EXPECT_FALSE((std::is_constructible_v<std::string, Secret>));
}

TEST(SecureKey, CopiesAreEqualAndTheirOwn) {
  auto one = key_of("000102030405060708090a0b0c0d0e0f");
  auto two = one;
  EXPECT_EQ(one, two);
  two.span()[15] = 0;
  EXPECT_NE(one, two);
  const auto moved = std::move(one);
  EXPECT_EQ(base::to_hex(moved.view()), "000102030405060708090a0b0c0d0e0f");
  two = moved;
  EXPECT_EQ(two, moved);
}

TEST(SecureKey, OnlySixteenBytesAreAKey) {
  EXPECT_TRUE(Key::from(Bytes(16)));
  for (const auto size : {0U, 15U, 17U, 32U}) {
    const auto key = Key::from(Bytes(size, 0xab));
    ASSERT_FALSE(key);
    EXPECT_EQ(key.error().code, ErrorCode::kInvalid);
    EXPECT_EQ(key.error().text.find("ab"), std::string::npos);
  }
}

TEST(SecureKey, SecretsOfDifferentLengthsDiffer) {
  EXPECT_EQ(Secret::of_text("one"), Secret::of_text("one"));
  EXPECT_FALSE(Secret::of_text("one") == Secret::of_text("two"));
  EXPECT_FALSE(Secret::of_text("one") == Secret::of_text("one1"));
  EXPECT_EQ(Secret(), Secret(std::size_t{0}));
}

TEST(SecureKey, WipesATextWithWhatWasBehindIt) {
  std::string text = "a password that is long enough for the heap";
  const auto* memory = text.data();
  const auto size = text.size();
  text.resize(3);
  wipe(text);
  EXPECT_TRUE(text.empty());
  EXPECT_EQ(text.capacity() >= size ? std::string(memory, memory + 3) : std::string(3, '\0'), std::string(3, '\0'));
}

/// Finds 16 bytes in the memory of this program that a core dump would include.
class CoreDump {
 public:
  /// The bytes are kept inverted, so that the test itself is not found.
  explicit CoreDump(ByteView wanted) {
    for (const auto byte : wanted) inverted_.push_back(static_cast<std::uint8_t>(~byte));
  }

  std::size_t times() {
    std::size_t found = 0;
    std::ifstream regions("/proc/self/smaps");
    std::string line;
    unsigned long long begin = 0, end = 0;
    bool writable = false;
    while (std::getline(regions, line)) {
      char dash = 0, mode[5] = {};
      std::istringstream head(line);
      unsigned long long first = 0, last = 0;
      if (line.find('-') < line.find(' ') && head >> std::hex >> first >> dash >> last >> mode) {
        begin = first;
        end = last;
        writable = mode[1] == 'w';
      } else if (line.starts_with("VmFlags:") && writable && end - begin < kMaxSize && line.find(" dd") == line.npos) {
        found += times_in(begin, end);
      }
    }
    return found;
  }

 private:
  std::size_t times_in(unsigned long long begin, unsigned long long end) {
    const int memory = ::open("/proc/self/mem", O_RDONLY);
    std::size_t found = 0;
    for (auto at = begin; at < end; at += kWindow) {
      const auto size = std::min<unsigned long long>(kWindow + inverted_.size(), end - at);
      const auto got = ::pread(memory, window_.data(), size, static_cast<off_t>(at));
      for (auto i = 0LL; i + static_cast<long long>(inverted_.size()) <= got; ++i) found += is_at(i) ? 1U : 0U;
    }
    ::close(memory);
    wipe(window_);
    return found;
  }
  bool is_at(long long at) const {
    for (std::size_t i = 0; i < inverted_.size(); ++i) {
      if (window_[static_cast<std::size_t>(at) + i] != static_cast<std::uint8_t>(~inverted_[i])) return false;
    }
    return true;
  }

  /// Larger regions are those of sanitizers.
  static constexpr unsigned long long kMaxSize = 1ULL << 28U;
  static constexpr std::size_t kWindow = 1U << 16U;
  Bytes inverted_;
  Bytes window_ = Bytes(kWindow + 64);
};

/// Two functions, so that the frames with copies are gone when the memory is searched.
[[gnu::noinline]] void use(const Key& key, Ccm& ccm) {
  Bytes content(40, 7);
  Block mac{};
  ASSERT_TRUE(ccm.seal(key, {}, hex("0102"), content, mac));
  ASSERT_TRUE(ccm.open(key, {}, hex("0102"), content, mac).value());
}

TEST(SecureKey, ACoreDumpHoldsNoKeyAfterItsUse) {
  if (!std::ifstream("/proc/self/smaps")) GTEST_SKIP() << "no /proc/self/smaps";
  Ccm ccm;
  const auto key = user_key(Secret::of_text("core dump"))->key;
  CoreDump dump(key.view());
  use(key, ccm);
  EXPECT_EQ(dump.times(), 0U) << "copies of the key in memory";
  const Bytes copy(key.view().begin(), key.view().end());
  EXPECT_GE(dump.times(), 1U) << "the search finds a copy on the heap: " << copy.size();
}

}  // namespace
}  // namespace rubicon::networks::knx::secure
