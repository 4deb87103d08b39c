#pragma once

#include <functional>
#include <memory>
#include <string>

#include "base/log.h"
#include "base/scheduler.h"
#include "trust/place.h"
#include "tuples/dds/dds_trust.h"

namespace rubicon::trust {

/// The trust of this process. Reads the folder when the engine asks, watches the end of the certificate, keeps the
/// signed list of revoked certificates, and asks the guard who others are. The newest list comes from the folder, from
/// the state folder of the place, or from other members; it is written to the first of both that this process may
/// write.
class Trust final : public tuples::dds::DdsTrust {
 public:
  /// Reads and checks all files; the error names the file, what is wrong and what was expected. The key is in the
  /// memory of this process from then on: keep_memory_private() is the program's.
  static Result<std::shared_ptr<Trust>> open(Place place, base::Scheduler& scheduler, Log log);
  ~Trust() override;

  Result<Documents> documents() override;
  std::string guard_library() const override;
  const tuples::Member& own() const override;
  std::optional<tuples::Member> who(const tuples::dds::GuidPrefix& participant) const override;
  bool take_revoked(std::string_view signed_list, std::string_view from) override;
  bool meets_revoked() const override;
  bool is_revoked() const override;
  std::string revoked() const override;
  void watch_revoked(std::function<void()> call) override;
  void watch_refused(Refused call) override;

  /// Days until the certificate of this process ends, rounded down; negative afterwards.
  int days_left() const;

 private:
  struct Impl;
  explicit Trust(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace rubicon::trust
