#include "network/supervisor.h"

#include <fmt/format.h>

#include <algorithm>
#include <random>

namespace rubicon::network {

namespace {
constexpr Duration kFirstPause = std::chrono::milliseconds(100);
}

/// One network, and the world as it sees it.
class Supervisor::Slot final : public NetworkHost {
 public:
  Slot(Supervisor& owner, const NetworkConfig& config, Duration longest_pause)
      : owner_(owner),
        id_(config.id),
        log_(owner.log_, config.id),
        longest_pause_(longest_pause),
        random_(static_cast<std::minstd_rand::result_type>(std::hash<std::string>{}(config.id))) {}

  using NetworkHost::deliver;
  void deliver(Message message) override;
  void failed(Error why) override;
  Scheduler& scheduler() override { return owner_.scheduler_; }
  transport::Transports& transports() override { return owner_.transports_; }
  const Log& log() const override { return log_; }

  Result<void> make(const NetworkType& type, const NetworkConfig& config);
  void open();
  Result<void> send(const Message& message) { return network_->send(message); }
  void line_down(std::string reason);

 private:
  Duration next_pause();

  Supervisor& owner_;
  std::string id_;
  Log log_;
  Duration longest_pause_;
  std::minstd_rand random_;
  unsigned failures_ = 0;
  Timer retry_;
  std::unique_ptr<Network> network_;  // last: destroyed first, while the host still stands
};

Result<void> Supervisor::Slot::make(const NetworkType& type, const NetworkConfig& config) {
  auto made = type.make(config, *this);
  if (!made) return fail(made.error());
  network_ = std::move(*made);
  return {};
}

void Supervisor::Slot::deliver(Message message) {
  if (const auto* state = std::get_if<model::State>(&message.body); state && state->line == model::LineState::kUp) {
    failures_ = 0;
  }
  message.source.island = owner_.island_;
  message.source.network = id_;
  if (message.destination.island == model::kNobody) message.destination.island = owner_.island_;
  owner_.sink_.from_network(id_, std::move(message));
}

void Supervisor::Slot::line_down(std::string reason) {
  deliver("", model::State{model::LineState::kDown, std::move(reason), {{"attempts", failures_}}});
}

Duration Supervisor::Slot::next_pause() {
  const auto doubled = kFirstPause * (1U << std::min(failures_, 16U));
  const auto pause = std::min<Duration>(doubled, longest_pause_);
  std::uniform_real_distribution<double> jitter(0.5, 1.0);
  return std::chrono::duration_cast<Duration>(pause * jitter(random_));
}

void Supervisor::Slot::failed(Error why) {
  if (retry_.pending()) return;
  retry_ = owner_.scheduler_.after(next_pause(), [this] { open(); });
  ++failures_;
  if (failures_ == 1) log_.warning(fmt::format("line lost: {}", why.text));
  line_down(std::move(why.text));
}

void Supervisor::Slot::open() {
  retry_.cancel();
  if (auto opened = network_->open(); !opened) failed(opened.error());
}

Supervisor::Supervisor(IslandId island, Scheduler& scheduler, transport::Transports& transports, base::LogSink& log,
                       MessageSink& sink)
    : island_(island), scheduler_(scheduler), transports_(transports), log_(log), sink_(sink) {}

Supervisor::~Supervisor() = default;

Result<void> Supervisor::add(const NetworkType& type, const NetworkConfig& config) {
  if (has(config.id)) return fail(ErrorCode::kDuplicate, fmt::format("network {} is already there", config.id));
  auto slot = std::make_unique<Slot>(*this, config, type.longest_pause);
  if (auto made = slot->make(type, config); !made) return made;
  auto& placed = *slots_.emplace(config.id, std::move(slot)).first->second;
  if (started_) placed.open();
  return {};
}

void Supervisor::start() {
  started_ = true;
  for (auto& [id, slot] : slots_) slot->open();
}

void Supervisor::remove(const std::string& id) {
  const auto found = slots_.find(id);
  if (found == slots_.end()) return;
  found->second->line_down("removed");
  slots_.erase(found);
}

bool Supervisor::has(const std::string& id) const { return slots_.contains(id); }

std::vector<std::string> Supervisor::ids() const {
  std::vector<std::string> all;
  for (const auto& [id, slot] : slots_) all.push_back(id);
  return all;
}

Result<void> Supervisor::send(const Message& message) {
  const auto found = slots_.find(message.destination.network);
  if (found == slots_.end()) {
    return fail(ErrorCode::kNotFound, fmt::format("no network '{}' on this island", message.destination.network));
  }
  return found->second->send(message);
}

}  // namespace rubicon::network
