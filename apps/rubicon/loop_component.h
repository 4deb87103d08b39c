#pragma once

#include <memory>

#include "apps/rubicon/settings.h"
#include "base/log.h"
#include "transport/asio_scheduler.h"
#include "transport/local_transports.h"
#include "tuples/engines/engines.h"

namespace rubicon::cli {

/// What a program complains about goes to standard error.
class PrintedWarnings final : public base::LogSink {
 public:
  void write(base::LogLevel level, std::string_view, std::string_view text) override;
};

/// A component of a program that runs until a signal and needs everything through which bytes enter and leave.
class LoopComponent {
 public:
  /// `name`: in lists of components.
  Result<void> open(client::Options options, const std::string& name);

  transport::Loop& loop() { return loop_; }
  transport::Transports& transports() { return transports_; }
  TupleSpace& space() { return *space_; }
  PrintedWarnings& log() { return log_; }
  /// Only some users of this host may enter the folder where its programs meet.
  bool closed() const { return closed_; }

 private:
  PrintedWarnings log_;
  transport::Loop loop_;
  transport::LocalTransports transports_{loop_};
  bool closed_ = false;
  std::unique_ptr<tuples::engines::Engines> ecology_;
  std::unique_ptr<tuples::Link> link_;
  std::unique_ptr<TupleSpace> space_;
};

}  // namespace rubicon::cli
