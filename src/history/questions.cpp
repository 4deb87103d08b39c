#include "history/questions.h"

#include <fmt/format.h>

#include <algorithm>
#include <new>
#include <utility>

#include "sqlite/interruption.h"

namespace rubicon::history {

namespace {

Error late() {
  constexpr auto kSeconds = std::chrono::duration_cast<std::chrono::seconds>(Questions::kLongest).count();
  return {
      ErrorCode::kExpired,
      fmt::format("history: the answer took longer than {} s; ask for a shorter time or for fewer series", kSeconds)};
}

/// What the worker knows of a question.
struct Job {
  std::shared_ptr<Keeper> keeper;
  Questions::Work work;
  Questions::Clock clock;
  const std::atomic<bool>& cancelled;

  Result<std::string> run() const {
    auto* store = keeper->store();
    if (!store) return fail(keeper->why());
    const auto end = clock() + Questions::kLongest;
    bool is_late = false;
    const auto ends = [&] {
      is_late = is_late || clock() >= end;
      return is_late || cancelled;
    };
    const sqlite::Interruption bound(store->database(), ends, keeper->ending());
    try {
      auto result = work(*store);
      if (!result && is_late) return fail(late());
      return result;
    } catch (const std::bad_alloc&) {
      return fail(ErrorCode::kBusy, "history: there is not enough memory for the answer; ask for fewer series");
    }
  }
};

}  // namespace

Handle Questions::ask(const std::string& caller, Work work, HistorySource::TextCall call) {
  auto asked = std::make_shared<Asked>();
  asked->call = std::move(call);
  drop_cancelled();
  if (auto taken = put(caller, {asked, std::move(work)}); !taken) {
    lifetime_.post(scheduler_, [asked, error = taken.error()] {
      if (!asked->cancelled) std::exchange(asked->call, nullptr)(fail(error));
    });
  }
  run_next();
  return Handle([asked] {
    asked->cancelled = true;
    asked->call = nullptr;
  });
}

Result<void> Questions::put(const std::string& caller, Waiting question) {
  std::size_t count = 0;
  for (const auto& line : lines_) count += line.questions.size();
  auto line = std::find_if(lines_.begin(), lines_.end(), [&](const Line& one) { return one.caller == caller; });
  const auto own = line == lines_.end() ? 0 : line->questions.size();
  if (count >= kMost || own >= kMostOfCaller)
    return fail(ErrorCode::kBusy,
                fmt::format("history: {} questions wait already, {} of them of this caller; ask again "
                            "when some are answered",
                            count, own));
  if (line == lines_.end()) line = lines_.insert(lines_.end(), {caller, {}});
  line->questions.push_back(std::move(question));
  return {};
}

void Questions::drop_cancelled() {
  for (auto& line : lines_)
    std::erase_if(line.questions, [](const Waiting& one) { return one.asked->cancelled.load(); });
  std::erase_if(lines_, [](const Line& line) { return line.questions.empty(); });
}

void Questions::run_next() {
  if (running_ || lines_.empty()) return;
  auto line = std::move(lines_.front());
  lines_.pop_front();
  auto question = std::move(line.questions.front());
  line.questions.pop_front();
  if (!line.questions.empty()) lines_.push_back(std::move(line));
  running_ = true;
  run(std::move(question));
}

void Questions::run(Waiting question) {
  const auto asked = question.asked;
  auto done = std::make_shared<HistorySource::TextCall>(lifetime_.guard([this, asked](Result<std::string> result) {
    running_ = false;
    run_next();
    if (!asked->cancelled) std::exchange(asked->call, nullptr)(std::move(result));
  }));
  Job job{keeper_, std::move(question.work), clock_, asked->cancelled};
  worker_.run([asked, job = std::move(job), done, &scheduler = scheduler_] {
    auto result = std::make_shared<Result<std::string>>(asked->cancelled ? std::string() : job.run());
    scheduler.post([done, result] { (*done)(std::move(*result)); });
  });
}

}  // namespace rubicon::history
