#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "support/folder.h"
#include "support/private_network.h"
#include "support/process.h"
#include "trust/guard/documents.h"

namespace rubicon::tuples::dds {

/// Two authorities, and who they certified.
struct Realm {
  trust::guard::Signer identity =
      trust::guard::make_authority("Rubicon test identities", trust::guard::Signs::Certificates);
  trust::guard::Signer permissions =
      trust::guard::make_authority("Rubicon test permissions", trust::guard::Signs::Documents);
};

/// Who takes part: the ids of the certificate, and the patterns of partitions that grant them.
struct Person {
  std::string name, ids, grant;
  long serial = 1;
};
inline const Person kHome{"home", "00000007-00000007", "00000007", 7};
inline const Person kDesk{"desk", "01a00000-01afffff", "01a?????", 0xde};
inline const Person kMallory{"mallory", "01b00000-01bfffff", "01b?????", 0xba};
inline constexpr std::uint32_t kDeskId = 0x01a00001, kMalloryId = 0x01b00001;

/// Processes of a realm in a network of their own.
class TrustedMembers : public testing::Test {
 protected:
  using Process = support::Process;

  void SetUp() override {
    if (!network_.entered()) GTEST_SKIP() << network_.reason();
  }
  /// Writes the documents of a person; a second time they are new ones.
  std::string documents(const Person& who, const Realm& realm) const;
  std::string documents(const Person& who) const { return documents(who, realm_); }
  std::unique_ptr<Process> member(const Person& who, std::uint32_t id, const std::string& folder) const;
  std::unique_ptr<Process> member(const Person& who, std::uint32_t id) const { return member(who, id, documents(who)); }
  std::unique_ptr<Process> home() const { return member(kHome, 7); }
  std::unique_ptr<Process> desk() const { return member(kDesk, kDeskId); }
  std::unique_ptr<Process> liar(const Person& who = kMallory) const;
  /// Whether the condition holds within a minute.
  static bool until(Process& process, const std::string& condition);
  /// The answer to a question: the words after the first.
  static std::string ask(Process& process, const std::string& question);
  /// Both see each other as that person.
  static void meet(Process& home, Process& desk);

  support::PrivateNetwork network_;
  support::Folder folder_;
  Realm realm_;
};

}  // namespace rubicon::tuples::dds
