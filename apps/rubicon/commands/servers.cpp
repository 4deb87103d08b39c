#include <fmt/format.h>

#include <csignal>

#include "apps/program/process.h"
#include "apps/rubicon/cli.h"
#include "apps/rubicon/loop_component.h"
#include "apps/rubicon/output/tuple_text.h"
#include "base/config_reader.h"
#include "config/service_config.h"
#include "history/history.h"
#include "model/json_members.h"
#include "transport/asio_scheduler.h"
#include "transport/local_transports.h"
#include "web/access/token_file.h"
#include "web/web_service.h"

namespace rubicon::cli {

namespace {

constexpr std::string_view kNever = "never";
/// The same key as an island uses, so that a page finds it.
constexpr const char* kHistoryStatus = "web.history.status";

struct WebOptions {
  std::string listen = "127.0.0.1:8642";
  config::WebTls tls;
  config::WebSetup setup;
  config::HistorySetup history;  ///< no file = none
  std::vector<std::string> patterns, exclude, metrics;
  std::string raw, size;
};

struct TokenOptions {
  std::string name, role = "view", file = "web.tokens";
};

/// A component that shows what the others have; it runs until a signal.
class WebProgram {
 public:
  explicit WebProgram(const Settings& settings) : settings_(settings), out_(1) {}

  Result<void> open(const WebOptions& wanted) {
    auto options = settings_.options;
    options.broker.all = true;  // the page lists all islands
    if (auto opened = component_.open(options, "rubicon web"); !opened) return opened;
    if (!wanted.history.file.empty()) {
      if (auto kept = keep(wanted.history); !kept) return kept;
    }
    auto service =
        web::WebService::open({.context = component_.loop().context(),
                               .scheduler = component_.loop().scheduler(),
                               .space = component_.space(),
                               .transports = component_.transports(),
                               .log = component_.log(),
                               .history = history_.get(),
                               .closed = component_.closed()},
                              wanted.setup, "", "rubicon web", {place_text(options), place_options(options)});
    if (!service) return fail(service.error());
    service_ = std::move(*service);
    return {};
  }

  /// SIGHUP reads tokens and certificate again.
  int run() {
    const auto address = service_->address();
    out_.line(settings_.json ? model::dump({{"address", address}}) : "open " + address);
    out_.flush();
    auto& loop = component_.loop();
    const transport::Signals ends(loop, {SIGINT, SIGTERM}, [&loop] { loop.stop(); });
    const transport::Signals hang_up(loop, {SIGHUP}, [this] {
      if (const auto read = service_->reload(); !read) print_error(read.error().text);
    });
    loop.run();
    program::end_within_seconds(kGood);
    return kGood;
  }

 private:
  /// A history of all that this component sees.
  Result<void> keep(const config::HistorySetup& setup) {
    auto worker = transport::start_worker("history");
    if (!worker) return fail(worker.error());
    history_ = std::make_unique<history::History>(
        setup, history::History::Context{component_.loop().scheduler(), std::move(*worker), component_.log()});
    history_->follow(component_.space());
    status_ = std::make_unique<history::StatusTuple>(component_.loop().scheduler(), component_.space(), kHistoryStatus,
                                                     *history_);
    return {};
  }

  const Settings& settings_;
  Output out_;
  LoopComponent component_;
  std::unique_ptr<history::History> history_;
  std::unique_ptr<history::StatusTuple> status_;
  std::unique_ptr<web::WebService> service_;
};

std::string check_raw(const std::string& text) {
  if (text == kNever) return {};
  const auto age = base::parse_duration(text);
  return age && *age >= config::kMinRaw ? std::string() : text + ": expected at least 1h, or never";
}

std::string check_size(const std::string& text) {
  const auto size = base::parse_size(text);
  return size && *size >= config::kMinHistory ? std::string() : text + ": expected a size of at least 1MB";
}

/// The texts, which were checked, become the setup.
void take_texts(WebOptions& options) {
  auto& history = options.history;
  if (!options.patterns.empty()) history.patterns = patterns_in(options.patterns);
  history.exclude = patterns_in(options.exclude);
  if (!options.raw.empty()) history.raw = base::parse_duration(options.raw);  // never: nullopt
  history.size = base::parse_size(options.size).value_or(history.size);
  options.setup.metrics = patterns_in(options.metrics);
}

int serve(const Settings& settings, WebOptions options) {
  take_texts(options);
  const auto listen = config::parse_web_listen(options.listen);
  if (!listen) {
    print_error(fmt::format("--listen {}: expected an IP address and a port, such as 127.0.0.1:8642", options.listen));
    return kUsage;
  }
  options.setup.listen = *listen;
  if (!options.tls.certificate.empty()) options.setup.tls = options.tls;
  WebProgram program(settings);
  const auto opened = program.open(options);
  if (opened) return program.run();
  print_error(opened.error().text);
  return opened.error().code == ErrorCode::kInvalid ? kUsage : kFailed;
}

int make_token(const Settings& settings, const TokenOptions& options) {
  transport::Loop loop;
  transport::LocalTransports transports(loop);
  const auto role = web::access::parse_role(options.role).value_or(web::Role::kView);
  const auto token = web::access::add_token(transports, options.file, options.name, role);
  if (!token) {
    print_error(token.error().text);
    return token.error().code == ErrorCode::kIo ? kFailed : kUsage;
  }
  Output out(1);
  out.line(
      settings.json
          ? model::dump({{"name", options.name}, {"role", options.role}, {"file", options.file}, {"token", *token}})
          : *token);
  return ended(out, kGood);
}

void add_history_options(CLI::App* app, WebOptions& options) {
  auto* file = app->add_option("--history", options.history.file,
                               "file of a history of all islands; created if it does not exist");
  app->add_option("--pattern", options.patterns, "values to keep in it (may be repeated); default: all of points")
      ->check(check_pattern)
      ->allow_extra_args(false)
      ->needs(file);
  app->add_option("--exclude", options.exclude, "but not these, such as presence (may be repeated)")
      ->check(check_pattern)
      ->allow_extra_args(false)
      ->needs(file);
  app->add_option("--raw", options.raw, "how long each value stays, or never to remove it; default: 30d")
      ->check(check_raw)
      ->needs(file);
  app->add_option("--size", options.size, "of its file; default: 8GB")->check(check_size)->needs(file);
}

}  // namespace

void add_web(Cli& cli) {
  const auto options = std::make_shared<WebOptions>();
  auto* app =
      cli.command({"web", "Serve the page and its API for the islands that this host finds",
                   "  rubicon web\n"
                   "  rubicon web --listen 127.0.0.1:8700\n"
                   "  sudo rubicon web enable home                     # the page of an island, with a token\n"},
                  [options](const Settings& settings) { return serve(settings, *options); });
  app->add_option("--listen", options->listen, "IP address and port; port 0 = any free one")->capture_default_str();
  auto* certificate =
      app->add_option("--certificate", options->tls.certificate, "PEM file; needed where others reach the port");
  auto* key = app->add_option("--key", options->tls.key, "PEM file with the key of the certificate");
  certificate->needs(key);
  key->needs(certificate);
  add_history_options(app, *options);
  app->add_option("--metrics", options->metrics, "values to show in /metrics (may be repeated)")
      ->check(check_pattern)
      ->allow_extra_args(false);
  app->add_flag("--compress", options->setup.compress, "compress WebSockets, for slow lines");
  app->add_option("--tokens", options->setup.tokens, "file with the tokens, which `rubicon token` makes");
  app->add_option("--host", options->setup.hosts, "name of this host in addresses (may be repeated)")
      ->allow_extra_args(false);
  app->add_option("--origin", options->setup.origins, "page of another server that may use this one: https://NAME")
      ->allow_extra_args(false);
  app->add_option("--files", options->setup.files, "folder with the page, instead of the one in the program");
  app->add_flag("--trust-lan", options->setup.trust_lan, "neither TLS nor tokens although others reach the port");
  add_web_enable(cli, app);
}

void add_token(Cli& cli) {
  const auto options = std::make_shared<TokenOptions>();
  auto* app = cli.command({"token", "Make a token for the page and its API; only its hash is kept",
                           "  rubicon token hall-panel --role command --file web.tokens\n"},
                          [options](const Settings& settings) { return make_token(settings, *options); });
  app->add_option("NAME", options->name, "who gets it")->required();
  app->add_option("--role", options->role, "view, command (sets tuples) or admin (inbox, reload, recorders)")
      ->check(CLI::IsMember({"view", "command", "admin"}))
      ->capture_default_str();
  app->add_option("--file", options->file, "file to append it to")->capture_default_str();
}

}  // namespace rubicon::cli
