#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "rubicon/tuple_space.hpp"
#include "transport/poll_loop.h"
#include "tuples/dds/dds_ecology.h"
#include "tuples/dds/trust/member/guard_trust.h"
#include "tuples/dds/trust/member/judged.h"

namespace rubicon::tuples::dds {

using Words = std::vector<std::string>;

/// Lines of the log, kept and written to standard error.
struct KeptLog final : base::LogSink {
  void write(base::LogLevel, std::string_view, std::string_view text) override;
  std::vector<std::string> lines;
};

/// One component that obeys commands; everybody may set its tuple `cmd`.
class Honest {
 public:
  Honest(transport::PollLoop& loop, KeptLog& log, std::shared_ptr<GuardTrust> trust)
      : loop_(loop), log_(log), trust_(std::move(trust)) {}

  Result<void> start(OwnerId id, Duration lease);
  void obey(const Words& words);
  /// Whether a condition holds: `peer 7 home`, `alone`, `value 7 a 1`, `log TEXT`, `answered 10`.
  bool holds(const Words& words) const;

 private:
  void send(OwnerId to, int count, int begun);
  void add_component(OwnerId id);

  transport::PollLoop& loop_;
  KeptLog& log_;
  std::shared_ptr<GuardTrust> trust_;
  std::unique_ptr<DdsEcology> ecology_;
  std::unique_ptr<Link> link_;
  std::unique_ptr<TupleSpace> space_;
  std::unique_ptr<Judged> judged_;
  std::unique_ptr<Link> other_link_;
  std::unique_ptr<TupleSpace> other_space_;
  Handle copies_, policy_, peers_;
  Timer sending_;
  int answered_ = 0, applied_ = 0, sent_ = 0, losses_ = 0;
  std::map<std::string, int> executed_;  ///< how often, by value
};

/// Words of a line, without blanks.
Words words_of(const std::string& line);

}  // namespace rubicon::tuples::dds
