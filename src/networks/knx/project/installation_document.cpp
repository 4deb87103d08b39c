#include "networks/knx/project/installation_document.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/text.h"
#include "networks/knx/groups/group_list.h"

namespace rubicon::networks::knx::project {

namespace {

std::string_view next_word(std::string_view& text) {
  const auto begin = std::min(text.find_first_not_of(' '), text.size());
  const auto end = std::min(text.find(' ', begin), text.size());
  const auto word = text.substr(begin, end - begin);
  text.remove_prefix(end);
  return word;
}

bool has_digits(std::string_view text) {
  return !text.empty() && text.find_first_not_of("0123456789") == text.npos;
}

/// The length of `M-20_MI-1_` at the beginning; 0 = it does not begin so.
std::size_t module_part(std::string_view text) {
  const auto first = text.find('_');
  const auto second = first == text.npos ? text.npos : text.find('_', first + 1);
  if (second == text.npos) return 0;
  const auto module = text.substr(0, first), instance = text.substr(first + 1, second - first - 1);
  const bool fits = module.starts_with("M-") && has_digits(module.substr(2)) && instance.starts_with("MI-") &&
                    has_digits(instance.substr(3));
  return fits ? second + 1 : 0;
}

/// The id of the program for the id of an instance: `MD-2_M-20_MI-1_O-2_R-3` -> `MD-2_O-2_R-3`, also for a module in a
/// module. `module` becomes `MD-2_M-20_MI-1` (knx.md, section 21.9).
std::string without_module(std::string_view id, std::string& module) {
  std::string out;
  std::size_t at = 0, begin = id.npos;
  while (at < id.size()) {
    const bool part_begins = at == 0 || id[at - 1] == '_';
    if (part_begins && id.substr(at).starts_with("MD-")) begin = at;
    const auto skip = part_begins && begin != id.npos ? module_part(id.substr(at)) : 0;
    if (skip == 0) {
      out += id[at++];
      continue;
    }
    at += skip;
    module = id.substr(begin, at - 1 - begin);
  }
  return out;
}

/// Long enough to see that it is too long for a field.
std::string field_of(const xml::Attributes& attributes, std::string_view name) {
  return std::string(attributes.text(name).substr(0, groups::kMaxFieldBytes + 1));
}

bool is_space(std::string_view name) {
  return name == "Space" || name == "BuildingPart";  // the latter: ETS 4
}

}  // namespace

std::string_view short_id(std::string_view id) {
  if (!id.starts_with("P-")) return id;
  const auto cut = id.find('_');
  return cut == id.npos ? id : id.substr(cut + 1);
}

bool InstallationDocument::bounded(std::size_t& count, std::size_t most, std::string_view what) {
  if (++count <= most) return true;
  parser().refuse(fmt::format("more than {} {}: file refused, nothing imported", most, what));
  return false;
}

/// An element outside an installation belongs to one without a name.
Installation& InstallationDocument::here() {
  if (installations_.empty()) installations_.emplace_back();
  return installations_.back();
}

void InstallationDocument::start(std::string_view name, const xml::Attributes& attributes) {
  if (name == "Installation") {
    if (installations_.size() < kMaxSpaces) installations_.emplace_back();
  } else if (name == "Area") {
    area_ = short_text(attributes, "Address");
  } else if (name == "Line") {
    line_ = short_text(attributes, "Address");
  } else if (name == "DeviceInstance") {
    start_device(attributes);
  } else if (name == "ComObjectInstanceRef") {
    start_object(attributes);
  } else if (name == "Send" || name == "Receive") {
    if (in_object_) link(attributes.text("GroupAddressRefId"));
  } else if (name == "ModuleInstance") {
    module_ = short_text(attributes, "Id");
  } else if (name == "Argument") {
    const bool wanted = in_device_ && !module_.empty() && bounded(arguments_, kMaxArguments, "arguments of modules");
    if (wanted)
      here().devices.back().arguments.push_back(
          {module_, short_text(attributes, "RefId"), short_text(attributes, "Value")});
  } else if (name == "GroupRange") {
    ranges_.push_back(groups::clean_text(attributes.text("Name"), groups::kMaxFieldBytes));
  } else if (name == "GroupAddress") {
    start_address(attributes);
  } else if (is_space(name)) {
    start_space(attributes);
  } else if (name == "DeviceInstanceRef") {
    place_device(attributes);
  } else if (name == "Function") {
    start_function(attributes);
  } else if (name == "GroupAddressRef") {
    add_member(attributes);
  }
}

void InstallationDocument::end(std::string_view name) {
  if (name == "DeviceInstance") {
    in_device_ = false;
  } else if (name == "ComObjectInstanceRef") {
    end_object();
  } else if (name == "ModuleInstance") {
    module_.clear();
  } else if (name == "GroupRange") {
    if (!ranges_.empty()) ranges_.pop_back();
  } else if (is_space(name)) {
    if (!spaces_.empty()) spaces_.pop_back();
  } else if (name == "Function") {
    in_function_ = false;
  } else if (name == "Installation") {
    end_installation();
  }
}

/// A device without an address (a power supply) has no objects on the bus and is left out.
void InstallationDocument::start_device(const xml::Attributes& attributes) {
  const auto address =
      wire::parse_individual(fmt::format("{}.{}.{}", area_, line_, base::trimmed(attributes.text("Address"))));
  in_device_ = address && bounded(devices_, kMaxDevices, "devices");
  if (!in_device_) return;
  auto& device = here().devices.emplace_back();
  device.address = *address;
  device.id = std::string(short_id(short_text(attributes, "Id")));
  device.name = short_text(attributes, "Name");
  device.description = short_text(attributes, "Description");
  device.product = short_text(attributes, "ProductRefId");
  device.hardware_program = short_text(attributes, "Hardware2ProgramRefId");
}

void InstallationDocument::start_object(const xml::Attributes& attributes) {
  in_object_ = in_device_;
  if (!in_object_) return;
  object_ = {};
  object_.id = without_module(attributes.text("RefId").substr(0, kMaxText), object_.module);
  object_.channel = short_text(attributes, "ChannelId");
  object_.traits = traits_of(attributes);
  auto links = attributes.text("Links");
  for (auto word = next_word(links); !word.empty(); word = next_word(links)) link(word);
}

void InstallationDocument::end_object() {
  if (in_object_ && !object_.links.empty() && bounded(objects_, kMaxObjects, "linked communication objects")) {
    keep(object_.id.size() + object_.channel.size() + object_.traits.types.size() + object_.traits.text.size());
    here().devices.back().objects.push_back(std::move(object_));
  }
  in_object_ = false;
}

/// Counts bytes of text that are kept.
void InstallationDocument::keep(std::size_t bytes) {
  texts_ += bytes;
  if (texts_ > kMaxTexts)
    parser().refuse(fmt::format("more than {} bytes of names and texts: file refused, nothing imported", kMaxTexts));
}

void InstallationDocument::link(std::string_view id) {
  if (bounded(links_, kMaxLinks, "links of communication objects"))
    object_.links.emplace_back(short_id(id.substr(0, kMaxText)));
}

void InstallationDocument::start_address(const xml::Attributes& attributes) {
  if (++addresses_ > groups::kMaxGroupAddresses) {
    ++left_out_;
    return;
  }
  auto& address = here().addresses.emplace_back();
  address.id = std::string(short_id(short_text(attributes, "Id")));
  address.number = short_text(attributes, "Address");
  address.name = field_of(attributes, "Name");
  address.description = field_of(attributes, "Description");
  address.types = field_of(attributes, "DatapointType");
  if (!ranges_.empty()) address.main_group = ranges_.front();
  if (ranges_.size() > 1) address.middle_group = ranges_[1];
  keep(address.name.size() + address.description.size() + address.main_group.size() + address.middle_group.size());
  address.security = short_text(attributes, "Security");
  address.has_key = !attributes.text("Key").empty();
  address.central = flag_of(attributes, "Central").value_or(false);
  address.unfiltered = flag_of(attributes, "Unfiltered").value_or(false);
  address.line = parser().line();
}

void InstallationDocument::start_space(const xml::Attributes& attributes) {
  if (!bounded(space_count_, kMaxSpaces, "rooms")) return;
  spaces_.push_back({short_text(attributes, "Name"), attributes.text("Type") == "DistributionBoard"});
}

/// `First floor / Kitchen`: the spaces from the building on, which is named only if there is nothing within it.
std::string InstallationDocument::room() const {
  std::string path;
  for (std::size_t i = spaces_.size() > 1 ? 1 : 0; i < spaces_.size(); ++i) {
    if (!spaces_[i].board && !spaces_[i].name.empty())
      path += fmt::format("{}{}", path.empty() ? "" : " / ", spaces_[i].name);
  }
  return groups::clean_text(path, kMaxText);
}

void InstallationDocument::place_device(const xml::Attributes& attributes) {
  const bool in_board = std::any_of(spaces_.begin(), spaces_.end(), [](const Space& space) { return space.board; });
  if (!spaces_.empty() && !in_board && rooms_.size() < kMaxDevices)
    rooms_.try_emplace(std::string(short_id(short_text(attributes, "RefId"))), room());
}

void InstallationDocument::start_function(const xml::Attributes& attributes) {
  in_function_ = bounded(functions_, kMaxFunctions, "functions");
  if (!in_function_) return;
  auto& function = here().functions.emplace_back();
  function.id = std::string(short_id(short_text(attributes, "Id")));
  function.name = short_text(attributes, "Name");
  function.type = short_text(attributes, "Type");
  function.room = room();
}

void InstallationDocument::add_member(const xml::Attributes& attributes) {
  if (in_function_ && bounded(members_, kMaxMembers, "addresses of functions"))
    here().functions.back().members.push_back(
        {std::string(short_id(short_text(attributes, "RefId"))), short_text(attributes, "Role")});
}

void InstallationDocument::end_installation() {
  for (auto& device : here().devices) {
    if (const auto found = rooms_.find(device.id); found != rooms_.end()) device.room = found->second;
  }
  rooms_.clear();
}

}  // namespace rubicon::networks::knx::project
