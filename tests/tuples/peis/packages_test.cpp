#include "tuples/peis/connection.h"

#include <gtest/gtest.h>
#include <malloc.h>

namespace rubicon::tuples::peis {
namespace {

/// SUBSCRIBE of 102 to 101 (peis.md, section 3.4); the last two bytes are padding that the kernel did not clear.
constexpr std::string_view kSubscribe =
    "ff00aa00 2b25e0f2 00000003 0a152142 0001 02 01 00000066 00000065 0005 00e4 0000 0000 0000 2020";

PackageHeader subscribe_header() {
  PackageHeader header;
  header.id = 0x2b25e0f2;
  header.counter = 3;
  header.ack_id = 0x0a152142;
  header.flags = kFlagWantsAck;
  header.routing = Routing::kDirect;
  header.hops = 1;
  header.source = OwnerId{102};
  header.destination = OwnerId{101};
  header.port = Port::kSubscribe;
  header.length = 228;
  return header;
}

Bytes package(std::uint32_t id, std::size_t size) {
  PackageHeader header = subscribe_header();
  header.id = id;
  header.length = static_cast<std::uint16_t>(size);
  Bytes bytes;
  append_package(bytes, header, Bytes(size, static_cast<std::uint8_t>(id)));
  return bytes;
}

Bytes header_with(std::size_t at, std::string_view replacement) {
  auto bytes = base::from_hex(kSubscribe).value();
  const auto patch = base::from_hex(replacement).value();
  std::copy(patch.begin(), patch.end(), bytes.begin() + static_cast<std::ptrdiff_t>(at));
  return bytes;
}

std::string error_with(std::size_t at, std::string_view replacement) {
  PackageStream stream;
  stream.append(header_with(at, replacement));
  const auto package = stream.next();
  return package ? "read" : package.error().text;
}

TEST(PeisPackages, AHeaderHasTheBytesOfTheReference) {
  const auto header = read_package_header(base::from_hex(kSubscribe).value());
  ASSERT_TRUE(header) << header.error().text;
  EXPECT_EQ(*header, subscribe_header());
  EXPECT_TRUE(header->wants_ack());
  Bytes out;
  append_package(out, subscribe_header(), Bytes(228));
  EXPECT_EQ(base::to_hex(ByteView(out).first(kHeaderSize)), base::to_hex(header_with(38, "0000"))) << "padding cleared";
  EXPECT_EQ(out.size(), kHeaderSize + 228);
}

TEST(PeisPackages, AResentPackageHasANewIdAndCounterOnly) {
  Bytes out{9, 9};
  append_package(out, subscribe_header(), Bytes(228, 7));
  restamp_package(std::span(out).subspan(2), 0x01020304, 77);
  auto expected = subscribe_header();
  expected.id = 0x01020304;
  expected.counter = 77;
  EXPECT_EQ(read_package_header(ByteView(out).subspan(2)).value(), expected);
}

TEST(PeisPackages, WhatWasTakenNeedsNoMemory) {
  const auto before = ::mallinfo2().uordblks;
  if (before == 0) GTEST_SKIP() << "the heap is that of a sanitizer";
  Bytes one = package(1, 1024);
  PackageStream stream;
  stream.append(one);
  for (std::uint32_t i = 0; i < 50; ++i) {
    ASSERT_TRUE(stream.next().value());
    stream.append(one);
  }
  Bytes many;
  for (int i = 0; i < 50; ++i) many.insert(many.end(), one.begin(), one.end());
  stream.append(many);
  many = Bytes();
  EXPECT_GT(::mallinfo2().uordblks, before + 50'000);
  while (stream.next().value()) continue;
  stream.shed();
  EXPECT_LT(::mallinfo2().uordblks, before + 10'000);
  stream.append(one);
  EXPECT_EQ(stream.next().value()->body.size(), 1024U);
}

TEST(PeisPackages, AStreamIsCutIntoPackagesWhereverItsPiecesEnd) {
  Bytes bytes = write(ConnectMessage{OwnerId{102}, 0, "default"});
  for (const auto& one : {package(1, 0), package(2, 1024), package(3, 1), package(4, 228)})
    bytes.insert(bytes.end(), one.begin(), one.end());
  for (const std::size_t piece : {1U, 7U, 40U, 75U, 1063U, 5000U}) {
    PackageStream stream;
    std::vector<std::size_t> sizes;
    bool connected = false;
    for (std::size_t at = 0; at < bytes.size(); at += piece) {
      stream.append(ByteView(bytes).subspan(at, std::min(piece, bytes.size() - at)));
      if (!connected) connected = stream.connect().value().has_value();
      if (!connected) continue;
      while (const auto package = stream.next().value()) {
        EXPECT_EQ(Bytes(package->body.begin(), package->body.end()),
                  Bytes(package->header.length, static_cast<std::uint8_t>(package->header.id)));
        sizes.push_back(package->body.size());
      }
    }
    EXPECT_EQ(sizes, (std::vector<std::size_t>{0, 1024, 1, 228})) << "pieces of " << piece;
    EXPECT_EQ(stream.pending(), 0U);
  }
}

TEST(PeisPackages, AnIncompletePackageIsKept) {
  PackageStream stream;
  const auto bytes = package(1, 100);
  stream.append(ByteView(bytes).first(139));
  EXPECT_FALSE(stream.next().value());
  EXPECT_EQ(stream.pending(), 139U);
  stream.append(ByteView(bytes).subspan(139));
  EXPECT_TRUE(stream.next().value());
}

TEST(PeisPackages, WhatIsNoPackageClosesTheConnection) {
  EXPECT_EQ(error_with(0, "ff00aa01"), "package: sync at 0: ff00aa01, expected ff00aa00");
  EXPECT_EQ(error_with(30, "0401"), "package: length at 30: 1025, expected at most 1024");
  EXPECT_EQ(error_with(4, "80000000"), "package: package id at 4: 80000000, expected 0 to 7fffffff");
  EXPECT_EQ(error_with(12, "ffffffff"), "package: ack id at 12: ffffffff, expected 0 to 7fffffff");
  EXPECT_EQ(error_with(20, "ffffffff"), "package: source at 20: ffffffff, expected 0 to 7fffffff");
  EXPECT_EQ(error_with(24, "fffffffe"), "package: destination at 24: fffffffe, expected 0 to 7fffffff");
}

TEST(PeisPackages, WhatANodeMustDropIsReadAndLeavesTheConnectionOpen) {
  const auto header_of = [](std::size_t at, std::string_view replacement) {
    return read_package_header(header_with(at, replacement)).value();
  };
  EXPECT_EQ(header_of(24, "ffffffff").destination, kEveryone);
  EXPECT_EQ(header_of(28, "0032").port, Port{50});
  EXPECT_EQ(header_of(18, "07").routing, Routing{7});
  EXPECT_EQ(header_of(19, "14").hops, 20);
  EXPECT_EQ(header_of(20, "00000000").source, OwnerId{0});
  EXPECT_EQ(header_of(4, "00000000").id, 0U);
}

TEST(PeisPackages, AnErrorIsFinal) {
  PackageStream stream;
  stream.append(header_with(0, "00"));
  const auto first = stream.next();
  ASSERT_FALSE(first);
  stream.append(package(1, 4));
  EXPECT_EQ(stream.next().error(), first.error());
  EXPECT_EQ(stream.connect().error(), first.error());
}

TEST(PeisPackages, AConnectionThatBeginsWithAnotherVersionIsClosed) {
  auto bytes = write(ConnectMessage{OwnerId{102}, 0, "default"});
  bytes[3] = 0xf5;
  PackageStream stream;
  stream.append(ByteView(bytes).first(75));
  EXPECT_FALSE(stream.connect().value());
  stream.append(ByteView(bytes).subspan(75));
  EXPECT_EQ(stream.connect().error().code, ErrorCode::kUnsupported);
  EXPECT_EQ(stream.next().error().code, ErrorCode::kUnsupported);
}

}  // namespace
}  // namespace rubicon::tuples::peis
