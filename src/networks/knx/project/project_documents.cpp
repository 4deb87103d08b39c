#include "networks/knx/project/project_documents.h"

#include "base/text.h"
#include "networks/knx/groups/group_list.h"
#include "networks/knx/project/installation_document.h"

namespace rubicon::networks::knx::project {

namespace {

constexpr std::string_view kNameSpace = "http://knx.org/xml/project/";
/// Bounds of what one manufacturer lists, and of the arguments of one program.
constexpr std::size_t kMaxListed = 100'000;

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
  if (name == "Product" && products_.size() < kMaxListed) {
    products_[short_text(attributes, "Id")] = {short_text(attributes, "Text"), short_text(attributes, "OrderNumber")};
  } else if (name == "Hardware2Program") {
    hardware_program_ = short_text(attributes, "Id");
  } else if (name == "ApplicationProgramRef" && !hardware_program_.empty() && programs_.size() < kMaxListed) {
    programs_.try_emplace(hardware_program_, short_text(attributes, "RefId"));
  }
}

void HardwareDocument::end(std::string_view name) {
  if (name == "Hardware2Program") hardware_program_.clear();
}

std::string HardwareDocument::program_of(const std::string& hardware_program) const {
  const auto found = programs_.find(hardware_program);
  return found == programs_.end() ? std::string() : found->second;
}

HardwareDocument::Product HardwareDocument::product_of(const std::string& product) const {
  const auto found = products_.find(product);
  return found == products_.end() ? Product{} : found->second;
}

void ProgramDocument::want(const std::string& reference) {
  if (references_.try_emplace(reference).second) ++missing_;
  if (objects_.try_emplace(std::string(object_of(reference))).second) ++missing_;
}

void ProgramDocument::take(std::unordered_map<std::string, Wanted>& wanted, const xml::Attributes& attributes) {
  const auto found = wanted.find(std::string(attributes.text("Id").substr(0, kMaxText)));
  if (found == wanted.end() || found->second.found) return;
  found->second.traits = project::traits_of(attributes);
  found->second.found = true;
  if (--missing_ == 0) parser().enough();
}

void ProgramDocument::start(std::string_view name, const xml::Attributes& attributes) {
  if (name == "ComObject") {
    take(objects_, attributes);
  } else if (name == "ComObjectRef") {
    take(references_, attributes);
  } else if (name == "Argument" && arguments_.size() < kMaxListed) {
    arguments_.try_emplace(short_text(attributes, "Id"), short_text(attributes, "Name"));
  }
}

ObjectTraits ProgramDocument::traits_of(const std::string& reference) const {
  const auto upper = references_.find(reference);
  const auto lower = objects_.find(std::string(object_of(reference)));
  const ObjectTraits none;
  return over(upper == references_.end() ? none : upper->second.traits,
              lower == objects_.end() ? none : lower->second.traits);
}

std::string ProgramDocument::argument_name(const std::string& id) const {
  const auto found = arguments_.find(id);
  return found == arguments_.end() ? std::string() : found->second;
}

void ParameterDocument::start(std::string_view name, const xml::Attributes& attributes) {
  if (name == "DeviceInstance") {
    device_ = short_id(short_text(attributes, "Id"));
  } else if (name == "ParameterInstanceRef") {
    const auto found = values_.find({device_, short_text(attributes, "RefId")});
    if (found != values_.end()) found->second = short_text(attributes, "Value");
  }
}

void ParameterDocument::end(std::string_view name) {
  if (name == "DeviceInstance") device_.clear();
}

std::string ParameterDocument::value_of(const std::string& device, const std::string& id) const {
  const auto found = values_.find({device, id});
  return found == values_.end() ? std::string() : found->second;
}

}  // namespace rubicon::networks::knx::project
