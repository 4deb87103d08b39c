#include "history/history.h"

#include <fmt/format.h>

#include <algorithm>
#include <new>
#include <tuple>
#include <utility>

#include "base/log.h"
#include "base/own_file.h"
#include "base/scheduler.h"
#include "base/text.h"
#include "history/history_source.h"
#include "history/intake.h"
#include "history/keeper.h"
#include "history/past.h"
#include "model/json_members.h"
#include "model/point_keys.h"
#include "sqlite/database.h"

namespace rubicon::history {

namespace {

Error late() {
  constexpr auto kSeconds = std::chrono::duration_cast<std::chrono::seconds>(Questions::kMaxTime).count();
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
    const auto end = clock() + Questions::kMaxTime;
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
  if (count >= kMaxCount || own >= kMaxOfCaller)
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

namespace {

constexpr Duration kWriteEvery = std::chrono::seconds(1);

/// The status and the description of what a pattern of values selects; nullopt where the pattern has them already.
std::optional<Pattern> beside(const Pattern& values, std::string_view part) {
  if (model::last_part(values.key) != "value") return std::nullopt;
  return Pattern{values.owner, fmt::format("{}.{}", model::parent_key(values.key), part)};
}

}  // namespace

struct History::Impl {
  Impl(config::HistorySetup of, Context with)
      : setup(std::move(of)),
        context(std::move(with)),
        log(Log(context.log, "history"), context.scheduler),
        intake(setup.exclude),
        path(base::whole_path(base::resolve_path(context.directory, setup.file))),
        keeper(std::make_shared<Keeper>(path, RetentionRules{setup.raw, setup.hours, setup.size})),
        questions(context.scheduler, *context.worker, keeper, clock()) {}

  void start();
  void write();
  void reported(Keeper::Report report);
  void put_in_log(const Keeper::Report& report);
  void warn();
  void subscribe();
  void observe(const tuples::Event& event);

  Questions::Clock clock() const {
    if (context.clock) return context.clock;
    return [&scheduler = context.scheduler] { return scheduler.now(); };
  }
  Instant now() const { return {context.scheduler.wall_now(), context.scheduler.now()}; }

  config::HistorySetup setup;
  Context context;
  base::LimitedLog log;
  Intake intake;
  std::string path;
  std::shared_ptr<Keeper> keeper;  ///< used by jobs of the worker only
  Questions questions;
  TupleSpace* space = nullptr;
  std::vector<Handle> subscriptions;
  HistoryCounters counters;
  std::string reason;
  bool opened = false;
  bool writing = false;  ///< a job of the worker
  std::uint64_t reported_drops = 0, reported_refusals = 0;
  Timer timer;
  base::Lifetime lifetime;
};

void History::Impl::start() {
  write();
  timer = context.scheduler.after(kWriteEvery, [this] { start(); });
}

/// One job at a time: while the disk does not answer, the points stay here, and the bound counts.
void History::Impl::write() {
  if (writing) return;
  writing = true;
  const auto at = now();
  intake.tick(at);
  auto batch = std::make_shared<Batch>(intake.take(at.wall));
  context.worker->run([keeper = keeper, batch, at, &scheduler = context.scheduler,
                       done = std::make_shared<std::function<void(Keeper::Report)>>(
                           lifetime.guard([this](Keeper::Report report) { reported(std::move(report)); }))] {
    auto report = std::make_shared<Keeper::Report>(keeper->work(std::move(*batch), at.steady, at.wall));
    scheduler.post([done, report] { (*done)(std::move(*report)); });
  });
}

void History::Impl::reported(Keeper::Report report) {
  writing = false;
  counters.points += report.points;
  counters.dropped += report.dropped;
  counters.failures += report.failures;
  counters.bytes = report.bytes;
  reason = std::move(report.reason);
  put_in_log(report);
  intake.limit(kMaxWaitingCount - std::min(report.waiting, kMaxWaitingCount));
  warn();
  if (!report.opened || std::exchange(opened, true)) return;
  intake.seed(report.series);
  log.unlimited().info(fmt::format("{}: {} series", path, report.series.size()));
  subscribe();
}

void History::Impl::put_in_log(const Keeper::Report& report) {
  for (const auto& [level, text] : report.log) {
    if (level == base::LogLevel::kError) {
      log.error(text, text);
    } else if (level == base::LogLevel::kWarning) {
      log.warning(text, text);
    } else {
      log.info(text, text);
    }
  }
}

/// Says what is not kept.
void History::Impl::warn() {
  if (intake.dropped() > reported_drops) {
    log.warning("dropped", fmt::format("{} points were dropped so far: {}", intake.dropped(),
                                       reason.empty() ? "the disk is too slow" : reason));
    reported_drops = intake.dropped();
  }
  if (intake.refused() > std::exchange(reported_refusals, intake.refused()))
    log.warning("series", fmt::format("there are {} series, the most; no others are kept", Intake::kMaxSeries));
  for (const auto& series : intake.take_unfit()) {
    const auto name = to_string(series.name);
    log.warning(name, fmt::format("{}: a value does not fit: the series has {}; such values are not kept", name,
                                  series.kind == SeriesKind::kNumber  ? "numbers"
                                  : series.kind == SeriesKind::kWords ? "256 short words at most"
                                                                      : "texts of 4 KiB at most"));
  }
}

void History::Impl::subscribe() {
  if (!opened || !space) return;
  const auto take = [this](const tuples::Event& event) { observe(event); };
  for (const auto& pattern : setup.patterns) {
    for (const auto* part : {"description", "status"}) {
      if (const auto other = beside(pattern, part))
        subscriptions.push_back(space->subscribe(*other, {setup.minimum, {}, 0, true}, take));
    }
    subscriptions.push_back(space->subscribe(pattern, {setup.minimum, {}, setup.dead_band, true}, take));
  }
}

void History::Impl::observe(const tuples::Event& event) {
  if (event.kind == tuples::EventKind::kSet) return intake.changed(event.tuple, now());
  intake.gone(event.tuple.owner, event.tuple.key, now());
}

History::History(config::HistorySetup setup, Context context)
    : impl_(std::make_unique<Impl>(std::move(setup), std::move(context))) {
  impl_->start();
}

History::~History() {
  auto& impl = *impl_;
  impl.timer.cancel();
  impl.subscriptions.clear();
  impl.lifetime.end();
  const auto at = impl.now();
  auto batch = std::make_shared<Batch>(impl.intake.take(at.wall));
  impl.keeper->end();
  Keeper::Report last;
  impl.context.worker->run(
      [keeper = impl.keeper, batch, at, &last] { last = keeper->finish(std::move(*batch), at.steady, at.wall); });
  impl.context.worker.reset();
  impl.put_in_log(last);
  if (last.unwritten == 0) return;
  impl.log.unlimited().error(fmt::format("{}: {} points are lost: {}", impl.path, last.unwritten, last.reason));
}

void History::follow(TupleSpace& space) {
  impl_->space = &space;
  impl_->subscribe();
}

Handle History::ask(const std::string& caller, Question question, AnswerText text, TextCall call) {
  auto work = [question = std::move(question), text = std::move(text)](Store& store) -> Result<std::string> {
    const auto found = answer(store, question);
    return found ? Result<std::string>(text(*found)) : fail(found.error());
  };
  return impl_->questions.ask(caller, std::move(work), std::move(call));
}

Handle History::series(const std::string& caller, Pattern pattern, SeriesRange range, SeriesText text, TextCall call) {
  auto work = [pattern = std::move(pattern), range = std::move(range),
               text = std::move(text)](Store& store) -> Result<std::string> {
    const auto found = list_series(store, pattern, range);
    return found ? Result<std::string>(text(*found)) : fail(found.error());
  };
  return impl_->questions.ask(caller, std::move(work), std::move(call));
}

HistoryCounters History::counters() const {
  auto counters = impl_->counters;
  counters.dropped += impl_->intake.dropped();
  counters.recording = impl_->opened && impl_->reason.empty();
  return counters;
}

History::State History::state() const {
  const auto& impl = *impl_;
  if (!impl.reason.empty()) return {"failing", impl.reason};
  return {impl.opened ? "recording" : "opening"};
}

const std::string& History::path() const {
  return impl_->path;
}

const config::HistorySetup& History::setup() const {
  return impl_->setup;
}

namespace {

constexpr Duration kLookAtStateEvery = std::chrono::seconds(1);
constexpr Duration kNumbersEvery = std::chrono::seconds(10);

}  // namespace

StatusTuple::StatusTuple(Scheduler& scheduler, TupleSpace& space, std::string key, const History& history)
    : scheduler_(scheduler), space_(space), key_(std::move(key)), history_(history) {
  look();
}

StatusTuple::~StatusTuple() {
  std::ignore = space_.erase(key_);
}

void StatusTuple::look() {
  timer_ = scheduler_.after(kLookAtStateEvery, [this] { look(); });
  const auto now = scheduler_.now();
  const auto state = history_.state();
  if (state == shown_ && now < numbers_due_) return;
  numbers_due_ = now + kNumbersEvery;
  if (std::exchange(shown_, state).word != state.word) since_ = scheduler_.wall_now();
  auto next = text();
  if (next == text_) return;
  text_ = std::move(next);
  std::ignore = space_.set(key_, text_, {"application/json", {}, {}});
}

std::string StatusTuple::text() const {
  const auto counters = history_.counters();
  return model::dump(nlohmann::ordered_json{{"state", shown_.word},
                                            {"reason", shown_.reason},
                                            {"since", model::seconds_json(since_)},
                                            {"file", history_.path()},
                                            {"bytes", counters.bytes},
                                            {"points", counters.points},
                                            {"dropped", counters.dropped}});
}

}  // namespace rubicon::history
