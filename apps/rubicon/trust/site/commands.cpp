#include "apps/rubicon/trust/site/commands.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <cstdlib>

#include "model/json_members.h"
#include "trust/site/site_identity.h"

namespace rubicon::cli::trust::site {

namespace {

namespace fs = std::filesystem;

std::string_view realm_variable() {
  const char* value = std::getenv("RUBICON_REALM");
  return value == nullptr || value == std::string_view("no") ? std::string_view() : value;
}

std::string islands_text(const std::vector<OwnerId>& islands) {
  std::vector<std::uint32_t> numbers;
  for (const auto one : islands) numbers.push_back(number(one));
  return fmt::format("{}", fmt::join(numbers, ", "));
}

}  // namespace

void add_site(Cli& cli, CLI::App* parent) {
  add_init(cli, parent);
  add_members(cli, parent);
  add_join(cli, parent);
  add_changes(cli, parent);
  add_show(cli, parent);
  add_broker(cli, parent);
}

void add_realm_option(CLI::App* app, std::string& folder) {
  app->add_option("--realm", folder, "folder of the realm; default /etc/rubicon/realm, or the user's own")
      ->type_name("FOLDER");
}

Result<fs::path> realm_folder(const std::string& named) {
  if (!named.empty() && named.find('/') == named.npos)
    return fail(
        ErrorCode::kInvalid,
        fmt::format("--realm {0}: is not a folder, expected one with a /, such as ./{0}; `init --name {0}` names "
                    "a realm",
                    named));
  if (!named.empty()) return fs::path(named);
  const auto variable = realm_variable();
  return variable.empty() ? fs::path(rubicon::trust::site::kHostSiteFolder) : fs::path(variable);
}

fs::path folder_to_show(const std::string& named) {
  if (!named.empty()) return named;
  if (!realm_variable().empty()) return realm_variable();
  const fs::path host = rubicon::trust::site::kHostSiteFolder;
  const auto own = rubicon::trust::site::own_site_folder();
  std::error_code error;
  return !fs::exists(host, error) && !own.empty() && fs::exists(own, error) ? own : host;
}

Result<fs::path> joined_folder(const std::string& named) {
  auto folder = realm_folder(named);
  if (!folder || !named.empty() || !realm_variable().empty() || ::geteuid() == 0) return folder;
  if (auto own = rubicon::trust::site::own_site_folder(); !own.empty()) return own;
  return fail(ErrorCode::kNotFound, "HOME is not set, expected --realm FOLDER");
}

Line as_json(const ListedSiteMember& member) {
  Line line{{"name", member.name}, {"roles", member.roles}, {"islands", Line::array()}};
  for (const auto one : member.islands) line["islands"].push_back(number(one));
  if (!member.also.empty()) line["islands_also_of"] = member.also;
  if (member.ends) line["expires"] = model::seconds_json(*member.ends);
  line["password"] = member.has_password;
  return line;
}

std::string member_text(const ListedSiteMember& member) {
  auto text = member.name;
  if (!member.roles.empty()) text += fmt::format(", roles {}", fmt::join(member.roles, " "));
  if (!member.islands.empty()) text += ", island " + islands_text(member.islands);
  if (!member.also.empty()) text += fmt::format(" (given to {}, too)", fmt::join(member.also, " "));
  if (member.has_password) text += ", with a password";
  if (member.ends) text += ", until " + time_text(*member.ends).substr(0, 10);
  return printable(text);
}

}  // namespace rubicon::cli::trust::site
