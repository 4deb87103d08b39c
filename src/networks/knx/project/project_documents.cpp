#include "networks/knx/project/project_documents.h"

#include "base/text.h"
#include "networks/knx/groups/group_list.h"
#include "networks/knx/project/installation_document.h"

namespace rubicon::networks::knx::project {

namespace {

constexpr std::string_view kNameSpace = "http://knx.org/xml/project/";
/// Of an element of values_ besides its texts.
constexpr std::size_t kValueOverhead = 96;

std::string_view object_of(std::string_view reference) {
  return reference.substr(0, reference.rfind("_R-"));
}

}  // namespace

void SchemaDocument::start(std::string_view, const xml::Attributes& attributes) {
  name_space_ = short_text(attributes, "xmlns");
  parser().enough();
}

std::optional<unsigned> SchemaDocument::schema() const {
  if (!name_space_.starts_with(kNameSpace)) return std::nullopt;
  return base::parse_number<unsigned>(std::string_view(name_space_).substr(kNameSpace.size()));
}

void ProjectDocument::start(std::string_view name, const xml::Attributes& attributes) {
  if (name != "ProjectInformation") return;
  name_ = short_text(attributes, "Name");
  const auto style = attributes.text("GroupAddressStyle");
  if (style == "TwoLevel") notation_ = wire::Notation::kTwoLevel;
  if (style == "Free") notation_ = wire::Notation::kFree;
  parser().enough();
}

void HardwareDocument::start(std::string_view name, const xml::Attributes& attributes) {
  if (name == "Hardware2Program") hardware_program_ = short_text(attributes, "Id");
  if (name != "ApplicationProgramRef") return;
  const auto found = programs_.find(hardware_program_);
  if (found != programs_.end() && found->second.empty()) found->second = keep(attributes, "RefId");
}

void HardwareDocument::end(std::string_view name) {
  if (name == "Hardware2Program") hardware_program_.clear();
}

std::string_view HardwareDocument::program_of(std::string_view hardware_program) const {
  const auto found = programs_.find(hardware_program);
  return found == programs_.end() ? std::string_view() : found->second;
}

void ProgramDocument::want(std::string_view reference) {
  if (references_.try_emplace(reference).second) ++missing_;
  if (objects_.try_emplace(object_of(reference)).second) ++missing_;
}

void ProgramDocument::take(Objects& wanted, const xml::Attributes& attributes) {
  const auto found = wanted.find(attributes.text("Id").substr(0, kMaxText));
  if (found == wanted.end() || found->second.found) return;
  found->second.traits = project::traits_of(attributes, texts());
  found->second.found = true;
  if (texts().is_exceeded()) {
    parser().refuse(texts().why());
  } else if (--missing_ == 0) {
    parser().enough();
  }
}

void ProgramDocument::start(std::string_view name, const xml::Attributes& attributes) {
  if (name == "ComObject") {
    take(objects_, attributes);
  } else if (name == "ComObjectRef") {
    take(references_, attributes);
  } else if (name == "Argument") {
    const auto found = arguments_.find(attributes.text("Id").substr(0, kMaxText));
    if (found != arguments_.end() && found->second.empty()) found->second = keep(attributes, "Name");
  }
}

std::optional<ObjectTraits> ProgramDocument::traits_of(std::string_view reference) const {
  const auto find = [](const Objects& objects, std::string_view id) -> const ObjectTraits* {
    const auto found = objects.find(id);
    return found == objects.end() || !found->second.found ? nullptr : &found->second.traits;
  };
  const auto* upper = find(references_, reference);
  const auto* lower = find(objects_, object_of(reference));
  if (upper == nullptr && lower == nullptr) return std::nullopt;
  const ObjectTraits none;
  return over(upper == nullptr ? none : *upper, lower == nullptr ? none : *lower);
}

std::string_view ProgramDocument::argument_name(std::string_view id) const {
  const auto found = arguments_.find(id);
  return found == arguments_.end() ? std::string_view() : found->second;
}

void ParameterDocument::want(std::string_view device, std::string_view id) {
  const auto kept = texts().keep(id);
  if (texts().charge(kValueOverhead)) values_.try_emplace({device, kept});
}

void ParameterDocument::start(std::string_view name, const xml::Attributes& attributes) {
  if (name == "DeviceInstance") {
    device_ = short_id(short_text(attributes, "Id"));
  } else if (name == "ParameterInstanceRef") {
    const auto id = attributes.text("RefId").substr(0, kMaxText);
    const auto found = values_.find({device_, id});
    if (found != values_.end()) found->second = keep(attributes, "Value");
  }
}

void ParameterDocument::end(std::string_view name) {
  if (name == "DeviceInstance") device_.clear();
}

std::string_view ParameterDocument::value_of(std::string_view device, std::string_view id) const {
  const auto found = values_.find({device, id});
  return found == values_.end() ? std::string_view() : found->second;
}

}  // namespace rubicon::networks::knx::project
