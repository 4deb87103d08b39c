#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <set>
#include <thread>

#include "support/folder.h"
#include "support/private_network.h"
#include "support/process.h"
#include "trust/guard/certificate.h"
#include "trust/guard/documents.h"
#include "trust/guard/peers.h"

namespace rubicon::trust::guard {
namespace {

using support::Process;

const std::string kGuard = RUBICON_GUARD;
const std::string kMember = RUBICON_BINARY_DIR "/bin/guard-member";
const std::string kLyingMember = RUBICON_BINARY_DIR "/bin/guard-lying-member";

const std::string kLiar = RUBICON_LIAR;

std::string hexadecimal(const Prefix& prefix) {
  std::string text;
  for (const auto byte : prefix) text += fmt::format("{:02x}", byte);
  return text;
}

/// Processes in a network of their own, with certificates of a realm with its two authorities.
class GuardTest : public testing::Test {
 protected:
  struct Grants {
    std::string writes, reads;
  };
  struct Endpoints {
    std::string writes, reads;
  };

  void SetUp() override {
    if (!network_.entered()) GTEST_SKIP() << network_.reason();
  }

  static Subject island() { return {.name = "island-7", .uris = {"rubicon:00000007-00000007"}}; }
  static Subject desk() {
    return {.name = "desk", .uris = {"rubicon:01a00000-01afffff", "rubicon-roles:admin,night"}, .serial = 0x1234};
  }
  static Subject mallory() { return {.name = "mallory", .uris = {"rubicon:01b00000-01bfffff"}, .serial = 0x66}; }

  /// What a member of the realm has.
  Documents documents(const Signer& member, const Subject& subject, const Grants& grants) const {
    return {identity_.certificate_pem(),
            member.certificate_pem(),
            member.key_pem(),
            permissions_.certificate_pem(),
            signed_text(permissions_, governance_xml()),
            signed_text(permissions_, permissions_xml(subject, grants.writes, grants.reads))};
  }
  Documents documents(const Subject& subject, const Grants& grants) const {
    return documents(make_member(identity_, subject), subject, grants);
  }
  Documents of_mallory() const { return documents(mallory(), {"01b?????.????????", "*.01b?????"}); }

  /// A process that writes `from-NAME` into one partition and reads another.
  std::vector<std::string> member(const std::string& name, const Documents& its, const Endpoints& endpoints,
                                  const std::string& library) const {
    its.write_to(folder_ / name);
    return {kMember,          "--documents", folder_ / name,  "--text",    "from-" + name, "--write",
            endpoints.writes, "--read",      endpoints.reads, "--library", library};
  }
  std::vector<std::string> island_member(const std::string& library) const {
    return member("island-7", documents(island(), {"00000007.????????", "*.00000007"}),
                  {"00000007.01a00001", "*.00000007"}, library);
  }
  std::vector<std::string> desk_member(const std::string& library) const {
    return member("desk", documents(desk(), {"01a?????.????????", "*.01a?????"}), {"01a00001.00000007", "*.01a00001"},
                  library);
  }
  /// As member(), with a modified stack.
  std::vector<std::string> liar(const Documents& its, const Endpoints& endpoints, const std::string& lies) const {
    auto command = member("mallory", its, endpoints, kLiar);
    command.insert(command.end(), {"--symbols", "liar"});
    command.front() = kLyingMember;
    command.insert(command.begin(), {"env", "LIAR=" + lies});
    return command;
  }

  /// Waits until Cyclone said this in a member's log (a minute at most).
  bool logs(const std::string& name, const std::string& part) const {
    const auto end = Clock::now() + std::chrono::minutes(1);
    while (Clock::now() < end) {
      std::ifstream file(folder_ / (name + "/log"));
      const std::string text(std::istreambuf_iterator<char>(file), {});
      if (text.find(part) != text.npos) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return false;
  }

  support::PrivateNetwork network_;
  support::Folder folder_;
  Signer identity_ = make_authority("Rubicon test identities", Signs::Certificates);
  Signer permissions_ = make_authority("Rubicon test permissions", Signs::Documents);
};

/// The built-in plug-ins.
const std::string kBare;

TEST_F(GuardTest, MembersMeetWithGuardsOnBothSidesAndKnowEachOther) {
  Process island(island_member(kGuard));
  Process desk(desk_member(kGuard));
  EXPECT_EQ(island.line_with("got"), "got *.00000007 from-desk");
  const auto who = island.line_with("who").value_or("");
  EXPECT_TRUE(who.starts_with("who desk 01a00000-01afffff admin,night 1234 ")) << who;
  EXPECT_EQ(desk.line_with("got"), "got *.01a00001 from-island-7");
  EXPECT_TRUE(desk.line_with("who").value_or("").starts_with("who island-7 00000007-00000007 - 01 "));
}

TEST_F(GuardTest, AMemberWithoutGuardMeetsOneThatHasIt) {
  Process island(island_member(kGuard));
  Process desk(desk_member(kBare));
  EXPECT_EQ(island.line_with("got"), "got *.00000007 from-desk");
  EXPECT_EQ(desk.line_with("got"), "got *.01a00001 from-island-7");
}

// -- a writer or reader without security attributes: access control is not asked

TEST_F(GuardTest, WithoutGuardAWriterWithoutAttributesWritesAsAnother) {
  Process desk(desk_member(kBare));
  Process mallory(liar(of_mallory(), {"00000007.01a00001", "*.01b00001"}, "any-partition no-bits"));
  EXPECT_EQ(desk.line_with("got"), "got *.01a00001 from-mallory");
}

TEST_F(GuardTest, AWriterWithoutAttributesIsRefusedAndNamed) {
  Process desk(desk_member(kGuard));
  Process mallory(liar(of_mallory(), {"00000007.01a00001", "*.01b00001"}, "any-partition no-bits"));
  const auto refused = desk.line_with("refused").value_or("");
  EXPECT_TRUE(refused.starts_with("refused mallory ")) << refused;
  EXPECT_TRUE(refused.ends_with(
      " verified a writer of rubicon_frames was announced without the attributes that permissions are asked for"))
      << refused;
  Process island(island_member(kGuard));
  EXPECT_EQ(desk.line_with("got"), "got *.01a00001 from-island-7");  // and nothing of mallory before
}

TEST_F(GuardTest, WithoutGuardAReaderWithoutAttributesReadsWhatIsForAnother) {
  Process island(island_member(kBare));
  Process mallory(liar(of_mallory(), {"01b00001.00000007", "*.01a00001"}, "any-partition no-bits"));
  EXPECT_EQ(mallory.line_with("got"), "got *.01a00001 from-island-7");
}

TEST_F(GuardTest, AReaderWithoutAttributesIsRefusedAndNamed) {
  Process island(island_member(kGuard));
  Process mallory(liar(of_mallory(), {"01b00001.00000007", "*.01a00001"}, "any-partition no-bits"));
  const auto refused = island.line_with(" a reader of rubicon_frames ").value_or("");
  EXPECT_TRUE(refused.starts_with("refused mallory ")) << refused;
  Process desk(desk_member(kGuard));
  EXPECT_EQ(island.line_with("readers"), "readers 00000007.01a00001 1");  // that of the desk
  EXPECT_EQ(desk.line_with("got"), "got *.01a00001 from-island-7");
}

// -- an endpoint that access control allows and that then matches none: its approval is left for the next

TEST_F(GuardTest, TheApprovalOfAWriterWithOtherAttributesServesNoneWithoutAttributes) {
  Process desk(desk_member(kGuard));
  auto lies =
      liar(of_mallory(), {"01b00001.01a00001", "*.01b00001"}, "any-partition other-bits:01b00001.01a00001 no-bits");
  lies.insert(lies.end(), {"--write", "00000007.01a00001"});
  Process mallory(lies);
  EXPECT_TRUE(desk.line_with(" a writer of rubicon_frames "));
  EXPECT_TRUE(logs("desk", "security_attributes mismatch")) << "the first writer was asked about";
  Process island(island_member(kGuard));
  EXPECT_EQ(desk.line_with("got"), "got *.01a00001 from-island-7");
}

TEST_F(GuardTest, TheApprovalOfAReaderWithOtherAttributesServesNoneWithoutAttributes) {
  const auto grants = documents(island(), {"00000007.????????", "*.00000007"});
  auto writes = member("island-7", grants, {"00000007.01b00001", "*.00000007"}, kGuard);
  writes.insert(writes.end(), {"--write", "00000007.01a00001"});
  Process island(writes);
  auto lies = liar(of_mallory(), {"01b00001.00000007", "*.01b00001"}, "any-partition other-bits:*.01b00001 no-bits");
  lies.insert(lies.end(), {"--read", "*.01a00001"});
  Process mallory(lies);
  EXPECT_TRUE(island.line_with(" a reader of rubicon_frames "));
  EXPECT_TRUE(logs("island-7", "security_attributes mismatch")) << "the first reader was asked about";
  Process desk(desk_member(kGuard));
  EXPECT_EQ(island.line_with("readers"), "readers 00000007.01a00001 1");  // that of the desk
  EXPECT_EQ(desk.line_with("got"), "got *.01a00001 from-island-7");
}

// -- the permissions of another member, rightly signed

class ForeignPermissionsTest : public GuardTest {
 protected:
  /// With her own certificate, and the document of island 7.
  std::vector<std::string> mallory_as_island() {
    return liar(of_mallory(), {"00000007.01a00001", "*.00000007"},
                "any-partition permissions:" + (folder_ / "island-7/permissions.p7s"));
  }
};

TEST_F(ForeignPermissionsTest, TheyAreRefusedWithoutGuard) {
  const auto honest = island_member(kBare);
  Process desk(desk_member(kBare));
  Process mallory(mallory_as_island());
  EXPECT_TRUE(logs("desk", "Subject name is invalid"));
  Process island(honest);
  EXPECT_EQ(desk.line_with("got"), "got *.01a00001 from-island-7");
  mallory.signal(SIGKILL);
  EXPECT_FALSE(mallory.line_with("got"));
}

TEST_F(ForeignPermissionsTest, TheyAreRefusedAndNamed) {
  const auto honest = island_member(kGuard);
  Process desk(desk_member(kGuard));
  Process mallory(mallory_as_island());
  const auto refused = desk.line_with("refused").value_or("");
  EXPECT_TRUE(refused.starts_with("refused mallory ")) << refused;
  EXPECT_NE(refused.find(" verified Subject name is invalid"), refused.npos) << refused;
  Process island(honest);
  EXPECT_EQ(desk.line_with("got"), "got *.01a00001 from-island-7");
  mallory.signal(SIGKILL);
  EXPECT_FALSE(mallory.line_with("got"));
}

// -- permissions that a member signs for herself

class OwnPermissionsTest : public GuardTest {
 protected:
  /// Mallory may write as island 7, says she, with a certificate that is good for everything.
  std::vector<std::string> mallory_as_island(const Signer& authority, const std::string& purposes = {}) const {
    auto subject = mallory();
    subject.purposes = purposes;
    const auto self = make_member(authority, subject);
    const auto grants = permissions_xml(subject, "00000007.????????", "*.00000007");
    // Her own process believes what she signed; to others she sends only the permissions.
    const Documents her{
        authority.certificate_pem(),         self.certificate_pem(),   self.key_pem(), authority.certificate_pem(),
        signed_text(self, governance_xml()), signed_text(self, grants)};
    return member("mallory", her, {"00000007.01a00001", "*.00000007"}, kBare);
  }
};

TEST_F(OwnPermissionsTest, WithOneAuthorityForAllTheyAreAccepted) {
  identity_ = make_authority("Rubicon test authority", Signs::Both);
  const auto self = make_member(identity_, desk());
  const Documents its{identity_.certificate_pem(),
                      self.certificate_pem(),
                      self.key_pem(),
                      identity_.certificate_pem(),
                      signed_text(identity_, governance_xml()),
                      signed_text(identity_, permissions_xml(desk(), "01a?????.????????", "*.01a?????"))};
  Process desk(member("desk", its, {"01a00001.00000007", "*.01a00001"}, kGuard));
  Process mallory(mallory_as_island(identity_));
  EXPECT_EQ(desk.line_with("got"), "got *.01a00001 from-mallory");
}

TEST_F(OwnPermissionsTest, WithTwoAuthoritiesTheyAreRefusedAndNamed) {
  Process desk(desk_member(kGuard));
  Process mallory(mallory_as_island(identity_));
  const auto refused = desk.line_with("refused").value_or("");
  EXPECT_TRUE(refused.starts_with("refused mallory ")) << refused;
  EXPECT_NE(refused.find(" verified Failed to parse PKCS7"), refused.npos) << refused;
  Process island(island_member(kGuard));
  EXPECT_EQ(desk.line_with("got"), "got *.01a00001 from-island-7");
}

TEST_F(OwnPermissionsTest, OurCertificatesCannotSignThem) {
  Process mallory(mallory_as_island(identity_, "clientAuth,serverAuth"));
  EXPECT_EQ(mallory.line(), "not-joined");
}

// -- the GUID of another

class ForeignGuidTest : public GuardTest {
 protected:
  /// Who begins a handshake is decided by comparing GUIDs, which both must do alike: a liar takes a name for that.
  std::vector<std::string> poser() {
    const auto own = make_member(identity_, desk());
    const auto reader = read_certificate(own.certificate_pem()).certificate->prefix;
    const auto victim = read_certificate(make_member(identity_, island()).certificate_pem()).certificate->prefix;
    for (int i = 0;; ++i) {
      auto subject = mallory();
      subject.name += std::to_string(i);
      const auto member = make_member(identity_, subject);
      const auto prefix = read_certificate(member.certificate_pem()).certificate->prefix;
      if ((prefix < reader) != (victim < reader)) continue;
      return liar(documents(member, subject, {"01b?????.????????", "*.01b?????"}), {"01b00001.01a00001", "*.01b00001"},
                  "prefix:" + hexadecimal(victim));
    }
  }
};

TEST_F(ForeignGuidTest, WithoutGuardItIsAccepted) {
  Process desk(desk_member(kBare));
  Process mallory(poser());
  EXPECT_EQ(desk.line_with("got"), "got *.01a00001 from-mallory");
}

TEST_F(ForeignGuidTest, ItIsRefusedAndNamed) {
  Process desk(desk_member(kGuard));
  Process mallory(poser());
  const auto refused = desk.line_with("refused").value_or("");
  EXPECT_TRUE(refused.starts_with("refused mallory")) << refused;
  EXPECT_TRUE(refused.ends_with(" verified its GUID belongs to the certificate of another")) << refused;
  Process island(island_member(kGuard));
  EXPECT_EQ(desk.line_with("got"), "got *.01a00001 from-island-7");
}

// -- who is refused for other reasons

TEST_F(GuardTest, ARevokedMemberIsRefusedAndNamed) {
  Process island(island_member(kGuard));
  island.write("revoke 001234\n");
  ASSERT_TRUE(island.line_with("revoked"));
  Process desk(desk_member(kGuard));
  const auto refused = island.line_with("refused").value_or("");
  EXPECT_TRUE(refused.starts_with("refused desk ")) << refused;
  EXPECT_TRUE(refused.ends_with(" verified its certificate is revoked")) << refused;
  Process other(member("mallory", of_mallory(), {"01b00001.00000007", "*.01b00001"}, kGuard));
  EXPECT_EQ(island.line_with("got"), "got *.00000007 from-mallory");
}

TEST_F(GuardTest, WhoForgetsAMemberThatIsRevoked) {
  Process island(island_member(kGuard));
  Process desk(desk_member(kGuard));
  ASSERT_TRUE(island.line_with("who desk"));
  island.write("revoke 1234\nwho\n");
  ASSERT_TRUE(island.line_with("revoked"));
  EXPECT_TRUE(island.line().value_or("").starts_with("nobody "));
}

TEST_F(GuardTest, ACertificateThatNamesItsIdsBadlyIsRefused) {
  Process island(island_member(kGuard));
  auto odd = desk();
  odd.uris = {"rubicon:00000000-ffffffff,"};
  Process desk(
      member("desk", documents(odd, {"01a?????.????????", "*.01a?????"}), {"01a00001.00000007", "*.01a00001"}, kBare));
  EXPECT_TRUE(island.line_with("refused").value_or("").ends_with(" its URI rubicon: is malformed"));
}

/// Members of another realm. The one that answers a handshake sees the certificate of the one that began: here the
/// island, as Cyclone lets the lower GUID begin.
class StrangersTest : public GuardTest {
 protected:
  std::vector<std::string> strangers(const std::string& count) {
    const auto authority = make_authority("Other identities", Signs::Certificates);
    const auto other = make_authority("Other permissions", Signs::Documents);
    const auto victim = read_certificate(make_member(identity_, island()).certificate_pem()).certificate->prefix;
    for (int i = 0;; ++i) {
      auto subject = mallory();
      subject.name = "stranger" + std::to_string(i);
      const auto self = make_member(authority, subject);
      if (read_certificate(self.certificate_pem()).certificate->prefix > victim) continue;
      const Documents its{authority.certificate_pem(),
                          self.certificate_pem(),
                          self.key_pem(),
                          other.certificate_pem(),
                          signed_text(other, governance_xml()),
                          signed_text(other, permissions_xml(subject, "*", "*"))};
      auto command = member("stranger", its, {"01b00001.00000007", "*.01b00001"}, kBare);
      command.insert(command.end(), {"--participants", count});
      return command;
    }
  }
};

TEST_F(StrangersTest, AMemberOfAnotherRealmIsRefusedAndNamed) {
  Process island(island_member(kGuard));
  Process stranger(strangers("1"));
  const auto refused = island.line_with("refused").value_or("");
  EXPECT_TRUE(refused.starts_with("refused stranger")) << refused;
  EXPECT_NE(refused.find(" claimed "), refused.npos) << refused;
  EXPECT_NE(refused.find("unable to get local issuer certificate"), refused.npos) << refused;
}

TEST_F(StrangersTest, TheyWaitLongerAfterEachRefusal) {
  Process island(island_member(kGuard));
  const auto begin = Clock::now();
  Process stranger(strangers("1"));
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(island.line_with("refused stranger")) << i;
  EXPECT_GE(Clock::now() - begin, 15 * Peers::kShortestWait) << "four waits, each twice as long as the one before";
}

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kSanitized = true;  // what was freed is kept, and as many take the time of 200
constexpr std::size_t kStrangers = 40;
#else
constexpr bool kSanitized = false;
constexpr std::size_t kStrangers = 200;
#endif

class CrowdTest : public StrangersTest {
 protected:
  /// Over less time the first handshakes would count for more than the waits after them.
  static std::chrono::seconds patience() {
    const char* seconds = std::getenv("RUBICON_CHAOS_SECONDS");
    return std::chrono::seconds(std::max(15, seconds == nullptr ? 0 : std::atoi(seconds)));
  }

  /// Reads until the island refused so many, and that time is over.
  void read_refused(Process& island, std::size_t count, Clock::time_point end) {
    while (refused_.size() < count || Clock::now() < end) {
      const auto line = island.line_with("refused stranger");
      ASSERT_TRUE(line) << refused_.size();
      const auto prefix = line->find(' ', std::string("refused ").size());
      refused_.insert(line->substr(prefix, 2 * std::tuple_size_v<GuidPrefix> + 1));
    }
  }

  /// What is left when all that is free was given back to the system.
  static long memory_of(Process& island) {
    island.write("memory\n");
    const std::string word = "memory ";
    return std::stol("0" + island.line_with(word).value_or(word).substr(word.size()));
  }

  /// Waits a minute at most: the strangers are forgotten some seconds after they are gone.
  static bool falls_below(Process& island, long kilobytes) {
    const auto end = Clock::now() + std::chrono::minutes(1);
    while (memory_of(island) >= kilobytes) {
      if (Clock::now() >= end) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    return true;
  }

  std::set<std::string> refused_;
};

TEST_F(CrowdTest, OfTwoHundredStrangersDoesNotHarmAnIsland) {
  Process island(island_member(kGuard));
  Process neighbour(desk_member(kGuard));
  ASSERT_TRUE(island.line_with("who desk"));
  const auto before = memory_of(island);
  const auto begin = Clock::now();
  const auto used_before = island.processor_time();
  {
    Process crowd(strangers(std::to_string(kStrangers)));
    read_refused(island, kStrangers, begin + patience());
    Process late(member("late", documents(desk(), {"01a?????.????????", "*.01a?????"}),
                        {"01a00002.00000007", "*.01a00002"}, kGuard));
    EXPECT_TRUE(island.line_with("got *.00000007 from-late")) << "the crowd takes the time of the island";
  }
  EXPECT_EQ(refused_.size(), kStrangers);
  const auto used = 100. * (island.processor_time() - used_before) / (Clock::now() - begin);
  const auto grown = island.resident_kilobytes() - before;
  RecordProperty("processor_percent", fmt::format("{:.1f}", used));
  RecordProperty("resident_kilobytes_grown", std::to_string(grown));
  island.write("who\n");
  EXPECT_TRUE(island.line_with("who desk"));
  if (kSanitized) return;
  constexpr double kMostPercent = 40;  // below 20 unless compilers run beside
  constexpr long kMostKilobytes = 40 * 1024;
  EXPECT_LT(used, kMostPercent) << "of one core";
  EXPECT_LT(grown, kMostKilobytes);
}

TEST_F(CrowdTest, TakesNoMemoryForGood) {
  if (kSanitized) GTEST_SKIP() << "sanitizers keep what was freed";
  Process island(island_member(kGuard));
  ASSERT_TRUE(island.line_with("joined"));
  constexpr long kMostLeft = 6 * 1024;
  const auto limit = memory_of(island) + kMostLeft;
  for (std::size_t crowds = 1; crowds <= 2; ++crowds) {
    {
      Process crowd(strangers(std::to_string(kStrangers)));
      read_refused(island, crowds * kStrangers, Clock::now());
    }
    EXPECT_TRUE(falls_below(island, limit)) << "after crowd " << crowds;
  }
}

}  // namespace
}  // namespace rubicon::trust::guard
