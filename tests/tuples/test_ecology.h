#pragma once

#include <memory>
#include <utility>

#include "base/virtual_scheduler.h"
#include "tuples/link.h"

namespace rubicon::tuples {

/// What the tests of the tuple space need of an engine: components that meet, are cut from each other and meet again.
class TestEngine {
 public:
  virtual ~TestEngine() = default;
  virtual Result<std::unique_ptr<Link>> join(OwnerId id) = 0;
  virtual void cut(OwnerId a, OwnerId b) = 0;
  virtual void mend(OwnerId a, OwnerId b) = 0;
};

template <class Ecology>
class TestEngineOf final : public TestEngine {
 public:
  explicit TestEngineOf(VirtualScheduler& time) : ecology_(time) {}
  Result<std::unique_ptr<Link>> join(OwnerId id) override { return ecology_.join(id); }
  void cut(OwnerId a, OwnerId b) override { ecology_.cut(a, b); }
  void mend(OwnerId a, OwnerId b) override { ecology_.mend(a, b); }

 private:
  Ecology ecology_;
};

// The suite is compiled once. Each program that links it has an engine of its own, and says here which.
std::unique_ptr<TestEngine> make_test_engine(VirtualScheduler& time);
/// Components see each other as soon as they are there, or after a turn.
extern const bool kMeetAtOnce;
/// Two components may use one id for a while, as two processes that do not know of each other.
extern const bool kOneIdMayStartTwice;

/// The engine of this program.
class TestEcology {
 public:
  explicit TestEcology(VirtualScheduler& time) : engine_(make_test_engine(time)) {}
  Result<std::unique_ptr<Link>> join(OwnerId id) { return engine_->join(id); }
  void cut(OwnerId a, OwnerId b) { engine_->cut(a, b); }
  void mend(OwnerId a, OwnerId b) { engine_->mend(a, b); }

 private:
  std::unique_ptr<TestEngine> engine_;
};

}  // namespace rubicon::tuples
