#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "trust/guard/guard.h"
#include "tuples/dds/dds_trust.h"

namespace rubicon::tuples::dds {

/// The trust of a member under test: documents of a folder, the guard, and lists of revoked certificates that are
/// `<number>:<serial>,<serial>:signed`; the name of this member in it stands for its own serial.
class GuardTrust final : public DdsTrust {
 public:
  GuardTrust(std::string folder, std::string guard, Member own);

  Result<Documents> documents() override;
  std::string guard_library() const override { return guard_; }
  const Member& own() const override { return own_; }
  std::optional<Member> who(const GuidPrefix& participant) const override;
  bool take_revoked(std::string_view signed_list, std::string_view from) override;
  bool meets_revoked() const override;
  bool is_revoked() const override;
  std::string revoked() const override { return list_; }
  void watch_revoked(std::function<void()> call) override { found_ = std::move(call); }
  void watch_refused(Refused call) override;
  int lists_checked() const { return lists_checked_; }

  /// A newer list lies in the folder.
  void find_revoked(std::string_view signed_list) {
    if (take_revoked(signed_list, {}) && found_) found_();
  }

  /// A newer list lies in the folder, where only the next documents() sees it.
  void lay_revoked(std::string_view signed_list) { laid_ = signed_list; }
  /// The next documents() are others.
  void replace_papers() { ++papers_; }

  /// Knows no peer until it may see again.
  void see(bool others) { sees_ = others; }
  void end_at(WallTime when) { own_.expires = when; }

 private:
  void* symbol(const char* name) const;
  void begin_watch();

  std::string folder_, guard_, list_, laid_;
  Member own_;
  unsigned long number_ = 0;
  std::atomic<bool> sees_{true};
  std::function<void()> found_;
  Refused refused_;
  int lists_checked_ = 0, papers_ = 0;
};

/// `00000007-00000007,01a00000-01afffff`
std::vector<IdRange> ranges_of(std::string_view text);

}  // namespace rubicon::tuples::dds
