#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "rights/audit.h"
#include "rights/rights.h"

namespace rubicon::rights {

/// The judge of a process: its rules, which a reload replaces, and the audit.
class RightsJudge final : public tuples::Judge {
 public:
  /// `audit`: null = nothing is recorded. `prefix`: the first part of the keys of the proxy, whose inbox needs the
  /// right to approve. `operators`: users of this host, such as `user:1000`, who may do everything without a rule.
  explicit RightsJudge(Rights rights, std::shared_ptr<Audit> audit = nullptr, std::string_view prefix = "proxy",
                       std::vector<std::string> operators = {});

  /// The spaces of the process must ask again: tuples::SpaceRights::rejudge().
  void replace(Rights rights) { rights_ = std::move(rights); }
  void record_by(std::shared_ptr<Audit> audit) { audit_ = std::move(audit); }
  const Rights& rights() const { return rights_; }

  tuples::Access access(const tuples::Member& who, std::string_view key) const override;
  bool sees_all(const tuples::Member& who) const override;
  Result<void> may_set(const tuples::Member& who, const tuples::RemoteSet& set) const override;
  Result<void> may_send(const tuples::Member& who, std::string_view where) const override;
  Result<void> may_by_names(const tuples::Member& who, tuples::Act act,
                            std::span<const std::string> names) const override;
  Result<void> would_allow(const tuples::Member& who, tuples::Act act,
                           std::span<const std::string> names) const override;
  bool may_vouch(const tuples::Member& who, std::string_view name) const override {
    return rights_.may_vouch(who, name);
  }
  tuples::Handle speak_for(const tuples::Member& who, OwnerId component, std::uint64_t request) override;
  const tuples::Member* spoken_for(OwnerId component, std::uint64_t request) const override;
  void answered(const tuples::Member& who, std::string_view host, const tuples::RemoteSet& set,
                const tuples::Reply& reply) override;
  void record(const tuples::Member& who, const tuples::OtherRequest& request, const Result<void>& answer) override;

  /// What the rules say, without counting it. For Right::kSet of a tuple of the inbox it answers for Right::kApprove,
  /// and of GATEWAY that it is allowed: the gateway asks about each message.
  Decision explain(const tuples::Member& who, Right right, std::string_view key) const;
  /// Sets and messages that the rules refused since the start.
  std::uint64_t refused() const { return refused_; }

 private:
  bool is_operator(const tuples::Member& who) const;
  bool is_of_inbox(std::string_view key) const;
  Right needed_to_set(std::string_view key) const { return is_of_inbox(key) ? Right::kApprove : Right::kSet; }
  Result<void> answer(const tuples::Member& who, Right right, std::string_view key) const;
  Error refusal(const tuples::Member& who, Right right, std::string_view key, const Decision& decision) const;
  bool refused_by_rules(const tuples::Member& who, std::string_view key, const tuples::Reply& reply) const;

  Rights rights_;
  std::shared_ptr<Audit> audit_;
  std::string inbox_;  ///< `proxy.inbox`
  std::vector<std::string> operators_;
  mutable std::uint64_t refused_ = 0;
  using Request = std::pair<OwnerId, std::uint64_t>;
  std::shared_ptr<std::map<Request, tuples::Member>> spoken_for_ =
      std::make_shared<std::map<Request, tuples::Member>>();  ///< shared with the handles, which may outlive this
};

}  // namespace rubicon::rights
