#include "apps/rubicon/session.h"

#include <fmt/format.h>

#include <poll.h>

#include <array>
#include <csignal>

#include "apps/program/process.h"

namespace rubicon::cli {

namespace {

/// A kernel announces itself each second, and has 0.5 s to say that it is a component of ours.
constexpr Duration kFirstPeerWait = std::chrono::seconds(1), kFirstKernelWait = std::chrono::seconds(3);
/// A stop of this process counts as one step of the wait.
constexpr Duration kStep = std::chrono::milliseconds(50);

volatile std::sig_atomic_t signalled = 0, ended_by = 0;
Client* woken = nullptr;

void on_signal(int number) {
  signalled = 1;
  ended_by = number;
  program::end_within_seconds(128 + number);
  if (woken) woken->stop();
}

}  // namespace

std::unique_ptr<Session> Session::open(const Settings& settings, std::string_view command) {
  auto session = std::unique_ptr<Session>(new Session(settings));
  auto options = settings.options;
  if (options.name.empty()) options.name = fmt::format("rubicon {}", command);
  if (!options.warn) options.warn = [](std::string_view text) { print_error(text); };
  auto client = Client::open(std::move(options));
  if (!client) {
    const auto place = place_text(settings.options);
    print_error(fmt::format("{}{}; run `rubicon doctor` to diagnose", client.error().text,
                            place.empty() ? "" : " (" + place + ")"));
    return nullptr;
  }
  session->client_ = std::move(*client);
  return session;
}

Session::~Session() {
  woken = nullptr;
  if (ended_by != 0) program::end_within_seconds(128 + ended_by);
}

WallTime Session::now() const {
  return std::chrono::floor<std::chrono::microseconds>(std::chrono::system_clock::now());
}

void Session::discover() {
  if (discovered_) return;
  discovered_ = true;
  const bool distant = uses(settings_.options, client::Engine::kDds);
  const auto longest = uses(settings_.options, client::Engine::kPeis) ? kFirstKernelWait
                       : distant                                      ? kFirstPeerWait
                                                                      : Duration(0);
  const auto somebody = [this] { return !client_->tuples().peers().empty(); };
  for (auto left = longest; left > Duration(0) && !somebody(); left -= kStep) client_->run_until(somebody, kStep);
  client_->discover(settings_.patience);
}

std::vector<client::Tuple> Session::read(const Pattern& pattern) {
  if (!pattern.owner) discover();
  return client_->read(pattern, settings_.patience);
}

std::string Session::component_text(OwnerId id) const {
  const auto text = client_->tuples().summary(id);
  const auto name = text.empty() ? std::string() : model::summary_from_json(text).value_or(Summary{}).name;
  return name.empty() ? std::to_string(number(id)) : fmt::format("{} ({})", number(id), printable(name));
}

void Session::catch_signals() {
  if (woken) return;
  woken = client_.get();
  struct sigaction action {};
  action.sa_handler = on_signal;  // not SA_RESTART: a write that waits for its reader ends too
  for (const int number : {SIGINT, SIGTERM}) ::sigaction(number, &action, nullptr);
}

bool Session::run(const std::function<bool()>& done, Duration patience) {
  catch_signals();
  bool is_done = false;
  const auto over = [&] {
    out_.flush();
    is_done = done();
    out_.flush();
    return is_done || interrupted() || out_.broken();
  };
  client_->run_until(over, patience);
  return is_done;
}

bool Session::turn(int descriptor) {
  std::array<pollfd, 2> waiting{{{client_->descriptor(), POLLIN, 0}, {descriptor, POLLIN, 0}}};
  const bool is_ready = ::poll(waiting.data(), waiting.size(), -1) > 0 && waiting[1].revents != 0;
  client_->poll();
  return is_ready;
}

client::Outcome Session::command(OwnerId owner, std::string_view key, std::string_view value) {
  const auto outcome = std::make_shared<std::optional<client::Outcome>>();
  client_->command(owner, key, value, [outcome](const client::Outcome& last) { *outcome = last; });
  run([&] { return outcome->has_value(); });
  return outcome->value_or(kEndedBySignal);
}

bool Session::interrupted() const {
  return signalled != 0;
}

void Session::resume() {
  signalled = 0;
  program::end_whenever_done();
}

int Session::not_found(const std::string& what, const std::string& hint) {
  out_.flush();
  const auto islands = client_->islands().size();
  const bool is_empty =
      islands == 0 && (!uses(settings_.options, client::Engine::kPeis) || client_->components().empty());
  const auto advice = is_empty ? "run `rubicon doctor` to diagnose" + elsewhere_text(settings_.options) : hint;
  print_error(fmt::format("{} (looked in {}; {} present){}{}", what, place_text(settings_.options),
                          counted(islands, "island"), advice.empty() ? "" : "; ", advice));
  return kNotThere;
}

int Session::end(int code) {
  return ended(out_, code);
}

}  // namespace rubicon::cli
