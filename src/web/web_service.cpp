#include "web/web_service.h"

#include <fmt/format.h>

#include <filesystem>
#include <utility>

#include "base/text.h"
#include "tuples/peer_policy.h"
#include "web/access/access.h"
#include "web/api/api.h"
#include "web/files/page.h"
#include "web/server/server.h"

namespace rubicon::web {

namespace {

using base::resolve_path;

access::AccessRules rules_of(const config::WebSetup& setup, bool needs_token) {
  access::AccessRules rules;
  rules.needs_token = needs_token || setup.tokens.has_value();
  rules.origins = {setup.hosts, setup.origins};
  return rules;
}

server::ServerOptions options_of(const config::WebSetup& setup, const std::string& directory) {
  server::ServerOptions options{.listen = {setup.listen.host, setup.listen.port}, .compress = setup.compress};
  if (setup.tls) {
    options.tls = {.certificate = resolve_path(directory, setup.tls->certificate),
                   .key = resolve_path(directory, setup.tls->key)};
  }
  return options;
}

std::unique_ptr<files::Page> page_of(const config::WebSetup& setup, const std::string& directory) {
  if (setup.files.empty()) return std::make_unique<files::EmbeddedPage>();
  return std::make_unique<files::FolderPage>(resolve_path(directory, setup.files));
}

bool is_any_address(const std::string& host) {
  return host == "0.0.0.0" || host == "::";
}

}  // namespace

struct WebService::Impl {
  Impl(const Parts& p, const config::WebSetup& s, std::string folder)
      : parts(p),
        setup(s),
        directory(std::move(folder)),
        is_judged(tuples::SpaceRights::judge(p.space) != nullptr),
        access(p.scheduler, rules_of(s, is_judged || p.closed)),
        page(page_of(s, directory)) {}

  Result<void> open(const std::string& name, const Place& place) {
    if (const auto wrong = config::web_exposure(setup); !wrong.empty()) return fail(ErrorCode::kInvalid, wrong);
    if (access.rules().needs_token && !setup.tokens)
      return fail(ErrorCode::kRefused,
                  fmt::format("web: {} each caller needs a token, on this host too: expected tokens: {{file: "
                              "web.tokens}}; `rubicon web enable` writes that, and makes a token",
                              is_judged ? "with rights" : "where several users have the folder of the host,"));
    auto tokens = tokens_of_setup();
    if (!tokens) return fail(tokens.error());
    access.take(std::move(*tokens));
    site = std::make_unique<api::Api>(parts.scheduler, parts.space, parts.log, access,
                                      api::ApiOptions{.name = name,
                                                      .place = place.text,
                                                      .place_options = place.options,
                                                      .metrics_patterns = setup.metrics,
                                                      .history = parts.history,
                                                      .island = parts.island,
                                                      .importer = parts.importer});
    auto opened = server::Server::open({parts.context, parts.scheduler, access, *site, *page, Log(parts.log, "web")},
                                       options_of(setup, directory));
    if (!opened) return fail(opened.error());
    server = std::move(*opened);
    access.name_cookie(server->local().port, server->secure());
    return {};
  }

  /// Takes the new tokens only together with the new certificate. Feeds that were opened by the rights of before end in
  /// any case.
  Result<void> reload() {
    if (is_judged) server->disconnect();
    auto tokens = tokens_of_setup();
    if (!tokens) return fail(tokens.error());
    if (auto read = server->reload(); !read) return read;
    if (access.take(std::move(*tokens)) && !is_judged) server->disconnect();
    return {};
  }

  Result<std::vector<access::Token>> tokens_of_setup() const {
    if (!setup.tokens) return std::vector<access::Token>{};
    auto tokens = access::read_tokens(parts.transports, resolve_path(directory, *setup.tokens));
    if (!tokens && tokens.error().code == ErrorCode::kNotFound)
      return fail(ErrorCode::kNotFound, tokens.error().text + "; `rubicon web enable` makes it, with a token");
    return tokens;
  }

  Parts parts;
  config::WebSetup setup;
  std::string directory;
  bool is_judged;
  access::Access access;
  std::unique_ptr<files::Page> page;
  std::unique_ptr<Site> site;
  std::unique_ptr<server::Server> server;
};

Result<std::unique_ptr<WebService>> WebService::open(const Parts& parts, const config::WebSetup& setup,
                                                     const std::string& directory, const std::string& name,
                                                     const Place& place) {
  auto impl = std::make_unique<Impl>(parts, setup, directory);
  if (auto opened = impl->open(name, place); !opened) return fail(opened.error());
  return std::unique_ptr<WebService>(new WebService(std::move(impl)));
}

WebService::WebService(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
WebService::~WebService() = default;

Result<void> WebService::reload() {
  return impl_->reload();
}

std::string WebService::address() const {
  const auto& setup = impl_->setup;
  auto local = impl_->server->local();
  if (!setup.hosts.empty()) local.address = setup.hosts.front();
  if (is_any_address(local.address)) local.address = "localhost";
  return (impl_->server->secure() ? "https://" : "http://") + to_string(local);
}

std::vector<std::pair<std::string, std::string>> faults_of_files(transport::Transports& transports,
                                                                 const config::WebSetup& setup,
                                                                 const std::string& directory) {
  std::vector<std::pair<std::string, std::string>> faults;
  if (const auto options = options_of(setup, directory); options.tls) {
    if (const auto tls = server::read_tls(*options.tls); !tls) faults.emplace_back("tls", tls.error().text);
  }
  if (setup.tokens) {
    const auto tokens = access::read_tokens(transports, resolve_path(directory, *setup.tokens));
    if (!tokens) faults.emplace_back("tokens", tokens.error().text);
  }
  std::error_code error;
  const auto folder = resolve_path(directory, setup.files);
  if (!setup.files.empty() && !std::filesystem::is_directory(folder, error))
    faults.emplace_back("files", "there is no folder " + folder);
  return faults;
}

}  // namespace rubicon::web
