#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "apps/rubicon/trust/commands.h"
#include "trust/site/site_operations.h"

namespace rubicon::cli::trust::site {

using rubicon::trust::site::BrokerUpdate;
using rubicon::trust::site::ListedSiteMember;

/// The commands of `rubicon trust` for the realm of MQTT brokers.
void add_site(Cli& cli, CLI::App* parent);
void add_init(Cli& cli, CLI::App* parent);
void add_members(Cli& cli, CLI::App* parent);
void add_join(Cli& cli, CLI::App* parent);
void add_changes(Cli& cli, CLI::App* parent);
void add_show(Cli& cli, CLI::App* parent);
void add_broker(Cli& cli, CLI::App* parent);

/// --realm FOLDER.
void add_realm_option(CLI::App* app, std::string& folder);
/// That of --realm, else of RUBICON_REALM, else of the host. kInvalid: it is not a folder.
Result<std::filesystem::path> realm_folder(const std::string& named);
/// The same. If neither names a folder and the host has none, it is the folder of the person.
std::filesystem::path folder_to_show(const std::string& named);
/// The folder that this user writes: for root the folder of the host, for others the one in the home directory.
Result<std::filesystem::path> joined_folder(const std::string& named);

/// name, roles, islands, until
Line as_json(const ListedSiteMember& member);
/// `hall, roles admin, island 6541, until 2028-01-01`.
std::string member_text(const ListedSiteMember& member);

/// What a process or unit has to read again after a change, and how; prints what could not be written. `asked`: PID or
/// unit of --reload, which gets the signal at once. The exit code.
int put_updates(const Settings& settings, Output& out, const std::vector<BrokerUpdate>& updates,
                const std::string& asked);
void add_reload_option(CLI::App* app, std::string& asked);

}  // namespace rubicon::cli::trust::site
