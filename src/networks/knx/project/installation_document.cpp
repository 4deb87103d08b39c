#include "networks/knx/project/installation_document.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/text.h"
#include "networks/knx/groups/encoding.h"
#include "networks/knx/groups/group_list.h"

namespace rubicon::networks::knx::project {

namespace {

bool has_only(std::string_view text, std::string_view characters) {
  return !text.empty() && text.find_first_not_of(characters) == text.npos;
}

/// The part of an id up to the next `_`.
std::string_view part_of(std::string_view text) {
  return text.substr(0, text.find('_'));
}

/// The length of `M-20_MI-1_` at the beginning, and of `M-1_MI-1-1-2_` in a module of a module; 0 = it does not begin
/// so.
std::size_t instance_at(std::string_view text) {
  const auto module = part_of(text);
  if (module.size() == text.size()) return 0;
  const auto instance = part_of(text.substr(module.size() + 1));
  const auto end = module.size() + 1 + instance.size();
  const bool fits = module.starts_with("M-") && has_only(module.substr(2), "0123456789") &&
                    instance.starts_with("MI-") && has_only(instance.substr(3), "0123456789-") && end < text.size();
  return fits ? end + 1 : 0;
}

/// The instance of a module in a module repeats the definition before it: `SM-1_M-1_MI-1-1-2_SM-1_`.
std::size_t repeated_definition_at(std::string_view text, std::string_view written) {
  const auto definition = part_of(text);
  if (!definition.starts_with("SM-") || definition.size() == text.size()) return 0;
  const auto with_end = text.substr(0, definition.size() + 1);
  const auto before = written.size() - std::min(written.size(), with_end.size());
  const bool repeats = written.ends_with(with_end) && (before == 0 || written[before - 1] == '_');
  return repeats ? with_end.size() : 0;
}

}  // namespace

std::string without_module(std::string_view id, std::string& module) {
  std::string out;
  std::size_t at = 0, begin = id.npos;
  while (at < id.size()) {
    const bool part_begins = at == 0 || id[at - 1] == '_';
    if (part_begins && id.substr(at).starts_with("MD-")) begin = at;
    const auto skip = part_begins && begin != id.npos ? instance_at(id.substr(at)) : 0;
    if (skip == 0) {
      out += id[at++];
      continue;
    }
    at += skip;
    module = id.substr(begin, at - 1 - begin);
    at += repeated_definition_at(id.substr(at), out);
  }
  return out;
}

namespace {

/// Of an element of an unordered map besides its key and value.
constexpr std::size_t kMapOverhead = 48;

std::string_view next_word(std::string_view& text) {
  const auto begin = std::min(text.find_first_not_of(' '), text.size());
  const auto end = std::min(text.find(' ', begin), text.size());
  const auto word = text.substr(begin, end - begin);
  text.remove_prefix(end);
  return word;
}

/// Long enough to see that it is too long for a field.
std::string_view field_of(const xml::Attributes& attributes, std::string_view name) {
  return attributes.text(name).substr(0, groups::kMaxFieldBytes + 1);
}

template <class Row, std::size_t size>
const Row* row_of(const Row (&rows)[size], std::string_view name) {
  const auto* found = std::find_if(std::begin(rows), std::end(rows), [&](const Row& row) { return row.name == name; });
  return found == std::end(rows) ? nullptr : found;
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
  using Self = InstallationDocument;
  struct Row {
    std::string_view name;
    Start start;
  };
  static constexpr Row kRows[] = {{"Installation", &Self::start_installation},
                                  {"Area", &Self::start_area},
                                  {"Line", &Self::start_line},
                                  {"DeviceInstance", &Self::start_device},
                                  {"ComObjectInstanceRef", &Self::start_object},
                                  {"Send", &Self::start_link},
                                  {"Receive", &Self::start_link},
                                  {"ModuleInstance", &Self::start_module},
                                  {"Argument", &Self::add_argument},
                                  {"GroupRange", &Self::start_range},
                                  {"GroupAddress", &Self::start_address},
                                  {"Space", &Self::start_space},
                                  {"BuildingPart", &Self::start_space},  // ETS 4
                                  {"DeviceInstanceRef", &Self::place_device},
                                  {"Function", &Self::start_function},
                                  {"GroupAddressRef", &Self::add_member}};
  if (const auto* row = row_of(kRows, name)) (this->*row->start)(attributes);
}

void InstallationDocument::end(std::string_view name) {
  using Self = InstallationDocument;
  struct Row {
    std::string_view name;
    End end;
  };
  static constexpr Row kRows[] = {{"DeviceInstance", &Self::end_device}, {"ComObjectInstanceRef", &Self::end_object},
                                  {"ModuleInstance", &Self::end_module}, {"GroupRange", &Self::end_range},
                                  {"Space", &Self::end_space},           {"BuildingPart", &Self::end_space},
                                  {"Function", &Self::end_function},     {"Installation", &Self::end_installation}};
  if (const auto* row = row_of(kRows, name)) (this->*row->end)();
}

void InstallationDocument::start_installation(const xml::Attributes& attributes) {
  if (installations_.size() < kMaxSpaces && charge(sizeof(Installation)))
    installations_.emplace_back().name = keep(attributes, "Name");
}

void InstallationDocument::start_device(const xml::Attributes& attributes) {
  in_device_ = bounded(devices_, kMaxDevices, "devices") && charge(sizeof(Device));
  if (!in_device_) return;
  auto& device = here().devices.emplace_back();
  const auto address =
      wire::parse_individual(fmt::format("{}.{}.{}", area_, line_, base::trimmed(attributes.text("Address"))));
  if (address) device.address = *address;
  device.id = short_id(keep(attributes, "Id"));
  device.hardware_program = keep(attributes, "Hardware2ProgramRefId");
}

/// Without an address and links it is a power supply, which has no objects on the bus.
void InstallationDocument::end_device() {
  auto& devices = here().devices;
  if (in_device_ && !devices.back().address && devices.back().objects.empty()) devices.pop_back();
  in_device_ = false;
}

void InstallationDocument::start_object(const xml::Attributes& attributes) {
  in_object_ = in_device_;
  if (!in_object_) return;
  object_ = {};
  auto& own = object_texts_.emplace();
  std::string module;
  object_.id = own.keep(without_module(attributes.text("RefId").substr(0, kMaxText), module));
  object_.module = own.keep(module);
  object_.channel = own.keep(short_text(attributes, "ChannelId"));
  object_.traits = traits_of(attributes, own);
  auto links = attributes.text("Links");
  for (auto word = next_word(links); !word.empty(); word = next_word(links)) link(word);
}

void InstallationDocument::end_object() {
  const bool wanted = in_object_ && !object_.links.empty();
  if (wanted && bounded(objects_, kMaxObjects, "linked communication objects") && charge(sizeof(LinkedObject))) {
    for (auto* text : {&object_.id, &object_.module, &object_.channel}) *text = keep(*text);
    object_.traits = kept_in(texts(), object_.traits);
    object_.links.shrink_to_fit();
    here().devices.back().objects.push_back(std::move(object_));
  }
  in_object_ = false;
}

void InstallationDocument::link(std::string_view id) {
  if (bounded(links_, kMaxLinks, "links of communication objects") && charge(sizeof(std::string_view)))
    object_.links.push_back(keep(short_id(id.substr(0, kMaxText))));
}

void InstallationDocument::start_link(const xml::Attributes& attributes) {
  if (in_object_) link(attributes.text("GroupAddressRefId"));
}

void InstallationDocument::add_argument(const xml::Attributes& attributes) {
  const bool wanted = in_device_ && !module_.empty() && bounded(arguments_, kMaxArguments, "arguments of modules");
  if (!wanted || !charge(sizeof(ModuleArgument))) return;
  std::string module;
  const auto id = keep(without_module(short_text(attributes, "RefId"), module));
  here().devices.back().arguments.push_back({module_, id, keep(attributes, "Value")});
}

void InstallationDocument::start_range(const xml::Attributes& attributes) {
  ranges_.push_back(groups::clean_text(attributes.text("Name"), groups::kMaxFieldBytes));
}

void InstallationDocument::end_range() {
  if (!ranges_.empty()) ranges_.pop_back();
}

void InstallationDocument::start_address(const xml::Attributes& attributes) {
  if (++addresses_ > groups::kMaxGroupAddresses) {
    ++left_out_;
    return;
  }
  const auto name = field_of(attributes, "Name"), description = field_of(attributes, "Description");
  const std::string_view main = ranges_.empty() ? std::string_view() : ranges_.front();
  const std::string_view middle = ranges_.size() > 1 ? std::string_view(ranges_[1]) : std::string_view();
  const auto bytes = name.size() + description.size() + main.size() + middle.size();
  if (!charge(sizeof(ProjectAddress) + bytes)) return;
  auto& address = here().addresses.emplace_back();
  address.id = short_id(keep(attributes, "Id"));
  address.number = keep(attributes, "Address");
  address.types = keep(field_of(attributes, "DatapointType"));
  address.security = keep(attributes, "Security");
  address.name = name;
  address.description = description;
  address.main_group = main;
  address.middle_group = middle;
  address.has_key = !attributes.text("Key").empty();
  address.central = enabled(attributes, "Central").value_or(false);
  address.unfiltered = enabled(attributes, "Unfiltered").value_or(false);
  address.line = parser().line();
}

void InstallationDocument::start_space(const xml::Attributes& attributes) {
  if (!bounded(space_count_, kMaxSpaces, "rooms")) return;
  if (spaces_.empty()) ++buildings_;
  spaces_.push_back({short_text(attributes, "Name"), attributes.text("Type") == "DistributionBoard"});
}

void InstallationDocument::end_space() {
  if (!spaces_.empty()) spaces_.pop_back();
}

/// `First floor / Kitchen`: the spaces inside the building. The building itself is named only if it has no spaces.
InstallationDocument::Place InstallationDocument::place() {
  if (!spaces_.empty() && building_in_use_.value_or(buildings_) != buildings_) several_buildings_ = true;
  if (!spaces_.empty() && !building_in_use_) building_in_use_ = buildings_;
  std::string path;
  for (std::size_t i = spaces_.size() > 1 ? 1 : 0; i < spaces_.size(); ++i) {
    if (!spaces_[i].board && !spaces_[i].name.empty())
      path += fmt::format("{}{}", path.empty() ? "" : " / ", spaces_[i].name);
  }
  const std::string_view building = spaces_.size() > 1 ? std::string_view(spaces_.front().name) : std::string_view();
  return {keep(building), keep(groups::clean_text(path, kMaxText))};
}

void InstallationDocument::place_device(const xml::Attributes& attributes) {
  const bool in_board = std::any_of(spaces_.begin(), spaces_.end(), [](const Space& space) { return space.board; });
  if (spaces_.empty() || in_board || device_places_.size() >= kMaxDevices) return;
  if (charge(sizeof(Place) + sizeof(std::string_view) + kMapOverhead))
    device_places_.try_emplace(short_id(keep(attributes, "RefId")), place());
}

void InstallationDocument::start_function(const xml::Attributes& attributes) {
  in_function_ = bounded(functions_, kMaxFunctions, "functions") && charge(sizeof(Function) + sizeof(Place));
  if (!in_function_) return;
  here().functions.push_back({short_id(keep(attributes, "Id")), keep(attributes, "Name"), {}, {}});
  function_places_.push_back(place());
}

void InstallationDocument::add_member(const xml::Attributes& attributes) {
  if (in_function_ && bounded(members_, kMaxMembers, "addresses of functions") && charge(sizeof(Function::Member)))
    here().functions.back().members.push_back({short_id(keep(attributes, "RefId")), keep(attributes, "Role")});
}

std::string_view InstallationDocument::room_of(const Place& place) {
  if (!several_buildings_ || place.building.empty() || place.room.empty()) return place.room;
  return keep(groups::clean_text(fmt::format("{} / {}", place.building, place.room), kMaxText));
}

void InstallationDocument::end_installation() {
  for (auto& device : here().devices) {
    if (const auto found = device_places_.find(device.id); found != device_places_.end())
      device.room = room_of(found->second);
  }
  auto& functions = here().functions;
  for (std::size_t i = 0; i < functions.size() && i < function_places_.size(); ++i)
    functions[i].room = room_of(function_places_[i]);
  device_places_.clear();
  function_places_.clear();
  building_in_use_.reset();
  several_buildings_ = false;
}

}  // namespace rubicon::networks::knx::project
