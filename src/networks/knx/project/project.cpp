#include "networks/knx/project/project.h"

#include <fmt/format.h>

#include <unordered_map>

#include "base/text.h"
#include "networks/knx/groups/encoding.h"
#include "networks/knx/groups/group_list_builder.h"
#include "networks/knx/project/installation_document.h"
#include "networks/knx/project/programs.h"
#include "networks/knx/project/project_documents.h"
#include "networks/knx/project/project_file.h"
#include "networks/knx/project/types.h"
#include "networks/knx/project/usage.h"

namespace rubicon::networks::knx::project {

namespace {

std::string form_of(unsigned schema) {
  const auto* program = schema < 12 ? "ETS 4" : schema < 21 ? "ETS 5" : "ETS 6";
  return fmt::format("project of {} (schema {})", program, schema);
}

/// Makes the list of one installation.
class InstallationList {
 public:
  InstallationList(const Installation& installation, groups::GroupListBuilder& builder)
      : installation_(installation), builder_(builder) {}

  void make() {
    take_addresses();
    take_objects();
    choose_types();
    take_functions();
    take_usage();
    for (std::size_t i = 0; i < entries_.size(); ++i) builder_.add(std::move(entries_[i]), changes_[i]);
  }

 private:
  void take_addresses() {
    for (const auto& from : installation_.addresses) {
      const auto address = builder_.address_of_number(from.line, from.number);
      if (!address) continue;
      index_.try_emplace(from.id, entries_.size());
      auto& changes = changes_.emplace_back();
      auto& entry = entries_.emplace_back();
      entry.line = from.line;
      entry.address = *address;
      entry.name = builder_.field("name", from.name, changes);
      entry.description = builder_.field("description", from.description, changes);
      entry.main_group = from.main_group;
      entry.middle_group = from.middle_group;
      entry.central = from.central;
      entry.unfiltered = from.unfiltered;
      entry.secured = from.has_key;
      if (!from.security.empty()) entry.security = from.security;
      entry.dpt = builder_.type(from.types, changes);
    }
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
    out.words = groups::words_of(traits.function_text);
    out.types = object_types(traits.types, traits.size);
    out.communicates = traits.communication.value_or(false);
    out.read = traits.read.value_or(false);
    out.write = traits.write.value_or(false);
    out.transmit = traits.transmit.value_or(false);
    for (const auto& link : object.links) {
      if (const auto found = index_.find(link); found != index_.end()) out.addresses.push_back(found->second);
    }
    if (!out.addresses.empty()) objects_.push_back(std::move(out));
  }

  void choose_types() {
    std::vector<std::vector<dpt::DptId>> of_objects(entries_.size());
    for (const auto& object : objects_) {
      for (const auto address : object.addresses) {
        for (const auto type : object.types) add_type(of_objects[address], type);
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
    std::vector<std::string> rooms(entries_.size());
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

  const Installation& installation_;
  groups::GroupListBuilder& builder_;
  std::unordered_map<std::string, std::size_t> index_;  ///< of entries_, by the id of the address
  std::vector<groups::GroupEntry> entries_;
  std::vector<std::vector<std::string>> changes_;  ///< for the report, one for each entry
  std::vector<BusObject> objects_;
  std::vector<Members> functions_;
};

Result<Project> read_parts(const ProjectFile& file) {
  Project project;
  project.id = file.id();
  project.schema = file.schema();
  project.was_protected = file.is_protected();
  ProjectDocument head;
  if (auto read = file.read_part("project.xml", head); !read) return fail(read.error());
  project.name = head.name();
  InstallationDocument body;
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
  complete_objects(file, project.installations, report);
  project.list.knows_plain = true;
  groups::GroupListBuilder builder(project.list, head.notation());
  for (const auto& installation : project.installations) InstallationList(installation, builder).make();
  if (project.list.entries.empty()) report.warning(0, {}, "the project has no group address");
  return project;
}

}  // namespace

Result<Project> read_project(std::unique_ptr<transport::FileSource> file, const std::string& source,
                             const ReadOptions& options) {
  const auto opened = ProjectFile::open(std::move(file), options);
  auto project = opened ? read_parts(*opened) : Result<Project>(fail(opened.error()));
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
  return groups::import_list(std::move(project->list), options);
}

}  // namespace rubicon::networks::knx::project
