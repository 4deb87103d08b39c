#include "history/history.h"

#include <fmt/format.h>

#include "base/lifetime.h"
#include "base/limited_log.h"
#include "base/text.h"
#include "base/whole_path.h"
#include "history/answer_text.h"
#include "history/intake.h"
#include "history/keeper.h"
#include "history/past.h"
#include "model/point_keys.h"

namespace rubicon::history {

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
  Counters counters;
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
  intake.limit(kMostWaiting - std::min(report.waiting, kMostWaiting));
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
    log.warning("series", fmt::format("there are {} series, the most; no others are kept", Intake::kMostSeries));
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

Counters History::counters() const {
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

}  // namespace rubicon::history
