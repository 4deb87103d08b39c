#include "networks/knx/project/project.h"

#include <fmt/format.h>

#include <map>
#include <unordered_map>
#include <utility>

#include "base/text.h"
#include "networks/knx/groups/encoding.h"
#include "networks/knx/groups/group_list_builder.h"
#include "networks/knx/project/installation_document.h"
#include "networks/knx/project/programs.h"
#include "networks/knx/project/project_documents.h"
#include "networks/knx/project/project_file.h"
#include "networks/knx/project/usage.h"
#include "rubicon/key.hpp"

namespace rubicon::networks::knx::project {

namespace {

std::string form_of(unsigned schema) {
  const auto* program = schema < 12 ? "ETS 4" : schema < 21 ? "ETS 5" : "ETS 6";
  return fmt::format("project of {} (schema {})", program, schema);
}

/// Which installation has an address, as its place in the project.
using Owners = std::unordered_map<std::uint16_t, std::size_t>;

/// `installation 2 'Garden'`.
std::string installation_text(const std::vector<Installation>& all, std::size_t place) {
  const auto& name = all[place].name;
  return fmt::format("installation {}{}", place + 1, name.empty() ? std::string() : " " + model::quoted(name));
}

/// Addresses of an installation that another one has too.
class Collisions {
 public:
  void add(wire::GroupAddress address, std::size_t other) {
    auto& found = by_other_[other];
    if (found.second++ == 0) found.first = address;
  }
  void report(const std::vector<Installation>& all, std::size_t place, groups::Report& report) const {
    for (const auto& [other, found] : by_other_) {
      report.doubled += found.second;
      report.error(
          0, found.first,
          fmt::format("{} has it, and so has {} ({} such addresses): the addresses of the second one are left out",
                      installation_text(all, other), installation_text(all, place), found.second));
    }
  }

 private:
  std::map<std::size_t, std::pair<wire::GroupAddress, std::size_t>> by_other_;  ///< the first address, and how many
};

/// Words and types of objects, by their texts: most objects of a project have the same.
class SharedMeanings {
 public:
  explicit SharedMeanings(KeptTexts& texts) : texts_(texts) {}

  const groups::NameWords* words_of(std::string_view text) {
    const auto [found, is_new] = words_.try_emplace(text);
    if (is_new && texts_.charge(sizeof(groups::NameWords) + 4 * text.size())) found->second = groups::words_of(text);
    return &found->second;
  }
  const std::vector<dpt::DptId>* types_of(std::string_view types, std::string_view size) {
    const auto [found, is_new] = types_.try_emplace({types, size});
    if (is_new && texts_.charge(sizeof(*found) + types.size())) found->second = object_types(types, size);
    return &found->second;
  }

 private:
  KeptTexts& texts_;
  std::map<std::string_view, groups::NameWords> words_;
  std::map<std::pair<std::string_view, std::string_view>, std::vector<dpt::DptId>> types_;
};

/// Makes the list of one installation.
class InstallationList {
 public:
  InstallationList(std::vector<Installation>& all, std::size_t place, groups::GroupListBuilder& builder,
                   KeptTexts& texts)
      : installation_(all[place]), builder_(builder), texts_(texts), meanings_(texts) {}

  /// Addresses that `owners` has stay with those, and are collisions; else `place` becomes their owner.
  void make(std::size_t place, Owners& owners, Collisions& collisions) {
    take_addresses(place, owners, collisions);
    take_objects();
    choose_types();
    take_functions();
    take_usage();
    for (std::size_t i = 0; i < entries_.size(); ++i) builder_.add(std::move(entries_[i]), changes_[i]);
  }

 private:
  void take_addresses(std::size_t place, Owners& owners, Collisions& collisions) {
    for (auto& from : installation_.addresses) {
      const auto address = builder_.address_of_number(from.line, from.number);
      if (!address) continue;
      const auto owner = owners.try_emplace(number(*address), place).first->second;
      if (owner != place) {
        collisions.add(*address, owner);
        continue;
      }
      index_.try_emplace(from.id, entries_.size());
      take_address(from, *address);
    }
  }

  void take_address(ProjectAddress& from, wire::GroupAddress address) {
    auto& changes = changes_.emplace_back();
    auto& entry = entries_.emplace_back();
    entry.line = from.line;
    entry.address = address;
    entry.name = builder_.field("name", std::exchange(from.name, {}), changes);
    entry.description = builder_.field("description", std::exchange(from.description, {}), changes);
    entry.main_group = std::move(from.main_group);
    entry.middle_group = std::move(from.middle_group);
    entry.central = from.central;
    entry.unfiltered = from.unfiltered;
    entry.secured = from.has_key;
    if (!from.security.empty()) entry.security = from.security;
    entry.dpt = builder_.type(from.types, changes);
  }

  void take_objects() {
    for (std::size_t device = 0; device < installation_.devices.size(); ++device) {
      for (const auto& object : installation_.devices[device].objects) take_object(device, object);
    }
  }

  void take_object(std::size_t device, const LinkedObject& object) {
    const auto& traits = object.traits;
    BusObject out;
    out.device = device;
    out.channel = object.channel.empty() ? traits.text : object.channel;
    out.words = meanings_.words_of(traits.function_text);
    out.types = meanings_.types_of(traits.types, traits.size);
    out.flags_known = traits.flags_are_known();
    out.communicates = traits.communication.value_or(false);
    out.read = traits.read.value_or(false);
    out.write = traits.write.value_or(false);
    out.transmit = traits.transmit.value_or(false);
    for (const auto& link : object.links) {
      if (const auto found = index_.find(link); found != index_.end()) out.addresses.push_back(found->second);
    }
    const bool kept = texts_.charge(sizeof(BusObject) + out.addresses.size() * sizeof(std::size_t));
    if (kept && !out.addresses.empty()) objects_.push_back(std::move(out));
  }

  void choose_types() {
    std::vector<std::vector<dpt::DptId>> of_objects(entries_.size());
    for (const auto& object : objects_) {
      for (const auto address : object.addresses) {
        for (const auto type : *object.types) add_type(of_objects[address], type);
      }
    }
    for (std::size_t i = 0; i < entries_.size(); ++i) {
      auto chosen = type_of(entries_[i].dpt, of_objects[i]);
      entries_[i].dpt = chosen.type;
      if (!chosen.change.empty()) changes_[i].push_back(std::move(chosen.change));
    }
  }

  /// The room of an address: of its function, else of the devices that use it, if they are in one room.
  void take_functions() {
    for (const auto& function : installation_.functions) {
      auto& members = functions_.emplace_back();
      for (const auto& member : function.members) {
        const auto found = index_.find(member.address);
        if (found == index_.end()) continue;
        members.emplace_back(found->second, member.role);
        auto& entry = entries_[found->second];
        if (entry.function.empty()) entry.function = function.name;
        if (entry.room.empty()) entry.room = function.room;
      }
    }
    std::vector<std::string_view> rooms(entries_.size());
    std::vector<bool> several(entries_.size());
    for (const auto& object : objects_) {
      const auto& room = installation_.devices[object.device].room;
      for (const auto address : object.addresses) {
        if (!room.empty() && !rooms[address].empty() && rooms[address] != room) several[address] = true;
        if (!room.empty()) rooms[address] = room;
      }
    }
    for (std::size_t i = 0; i < entries_.size(); ++i) {
      if (entries_[i].room.empty() && !several[i]) entries_[i].room = rooms[i];
    }
  }

  void take_usage() {
    const auto usage = usage_of(objects_, entries_, functions_);
    for (std::size_t i = 0; i < entries_.size(); ++i) {
      entries_[i].use = usage.uses[i];
      if (usage.states[i]) entries_[i].state = entries_[*usage.states[i]].address;
    }
  }

  Installation& installation_;
  groups::GroupListBuilder& builder_;
  KeptTexts& texts_;
  SharedMeanings meanings_;
  std::unordered_map<std::string_view, std::size_t> index_;  ///< of entries_, by the id of the address
  std::vector<groups::GroupEntry> entries_;
  std::vector<std::vector<std::string>> changes_;  ///< for the report, one for each entry
  std::vector<BusObject> objects_;
  std::vector<Members> functions_;
};

void make_list(Project& project, wire::Notation notation) {
  groups::GroupListBuilder builder(project.list, notation);
  Owners owners;
  for (std::size_t place = 0; place < project.installations.size(); ++place) {
    Collisions collisions;
    InstallationList(project.installations, place, builder, *project.texts).make(place, owners, collisions);
    collisions.report(project.installations, place, project.list.report);
  }
}

Result<Project> read_parts(const ProjectFile& file, std::size_t kept) {
  Project project;
  project.id = file.id();
  project.schema = file.schema();
  project.was_protected = file.is_protected();
  ProjectDocument head;
  if (auto read = file.read_part("project.xml", head); !read) return fail(read.error());
  project.name = head.name();
  project.texts = std::make_shared<KeptTexts>(kept);
  InstallationDocument body(*project.texts);
  if (auto read = file.read_part("0.xml", body); !read) return fail(read.error());
  project.installations = body.take();
  auto& report = project.list.report;
  report.form = form_of(project.schema);
  if (project.schema > kNewestSchema)
    report.warning(0, {},
                   fmt::format("schema {} is newer than {}: what it added is not read", project.schema, kNewestSchema));
  if (body.addresses_left_out() != 0)
    report.error(0, {},
                 fmt::format("more than {} group addresses: {} are left out", groups::kMaxGroupAddresses,
                             body.addresses_left_out()));
  if (auto done = complete_objects(file, project.installations, *project.texts, report); !done)
    return fail(done.error());
  project.list.knows_plain = true;
  make_list(project, head.notation());
  if (project.texts->is_exceeded()) return fail(ErrorCode::kOutOfRange, project.texts->why());
  if (project.list.entries.empty()) report.warning(0, {}, "the project has no group address");
  return project;
}

}  // namespace

Result<Project> read_project(std::unique_ptr<transport::FileSource> file, const std::string& source,
                             const ReadOptions& options) {
  const auto opened = ProjectFile::open(std::move(file), options);
  auto project = opened ? read_parts(*opened, options.kept) : Result<Project>(fail(opened.error()));
  if (!project) return fail(project.error().code, fmt::format("{}: {}", source, project.error().text));
  project->list.report.source = source;
  return project;
}

Result<bool> is_project(transport::FileSource& file, const std::string& name) {
  if (groups::to_lower(name).ends_with(".knxproj")) return true;
  Bytes begin(4);
  if (auto moved = file.seek(0); !moved) return fail(moved.error());
  const auto count = file.read(begin);
  if (!count) return fail(count.error());
  if (auto moved = file.seek(0); !moved) return fail(moved.error());
  const auto text = base::as_text(begin);
  return text == "PK\x03\x04" || text == "PK\x05\x06";
}

Result<groups::Import> import_project(std::unique_ptr<transport::FileSource> file, const std::string& source,
                                      const ReadOptions& how, const groups::ImportOptions& options) {
  auto project = read_project(std::move(file), source, how);
  if (!project) return fail(project.error());
  auto list = std::move(project->list);
  *project = {};  // frees what was needed to make the list
  return groups::import_list(std::move(list), options);
}

}  // namespace rubicon::networks::knx::project
