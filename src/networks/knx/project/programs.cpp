#include "networks/knx/project/programs.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <unordered_map>

#include "base/printable.h"
#include "networks/knx/project/project_documents.h"

namespace rubicon::networks::knx::project {

namespace {

/// `M-0083` of an id of this manufacturer; empty if it is not one.
std::string manufacturer_of(std::string_view id) {
  const auto end = id.find('_');
  const auto name = id.substr(0, end);
  const bool sound = end != id.npos && name.starts_with("M-") && name.find_first_of("/\\.") == name.npos;
  return sound ? std::string(name) : std::string();
}

/// An object, and the device that has it.
struct ObjectOfDevice {
  Device* device;
  LinkedObject* object;
};

class Completion {
 public:
  Completion(const ProjectFile& file, std::vector<Installation>& installations, groups::Report& report)
      : file_(file), report_(report) {
    for (auto& installation : installations) {
      for (auto& device : installation.devices) devices_.push_back(&device);
    }
  }

  void run() {
    read_hardware();
    std::map<std::string, std::vector<ObjectOfDevice>> programs;
    for (auto* device : devices_) {
      for (auto& object : device->objects) programs[device->program].push_back({device, &object});
    }
    for (const auto& [program, uses] : programs) read_program(program, uses);
    fill_parameters();
  }

 private:
  void read_hardware() {
    std::map<std::string, std::vector<Device*>> manufacturers;
    for (auto* device : devices_) manufacturers[manufacturer_of(device->hardware_program)].push_back(device);
    for (const auto& [manufacturer, devices] : manufacturers) {
      if (manufacturer.empty()) continue;
      HardwareDocument hardware;
      if (const auto read = file_.read_entry(manufacturer + "/Hardware.xml", hardware); !read)
        report_.warning(0, {}, fmt::format("devices of {}: {}", manufacturer, read.error().text));
      for (auto* device : devices) {
        device->program = hardware.program_of(device->hardware_program);
        const auto product = hardware.product_of(device->product);
        device->product_name = product.name;
        device->order_number = product.order_number;
      }
    }
  }

  void read_program(const std::string& program, const std::vector<ObjectOfDevice>& uses) {
    ProgramDocument document;
    for (const auto& use : uses) {
      if (!use.object->id.starts_with("M-")) use.object->id = fmt::format("{}_{}", program, use.object->id);
      document.want(use.object->id);
    }
    const auto name = fmt::format("{}/{}.xml", manufacturer_of(program), program);
    const auto read = program.empty() ? Result<void>(fail(ErrorCode::kNotFound, "not named in Hardware.xml"))
                                      : file_.read_entry(name, document);
    if (!read)
      report_.warning(0, {},
                      fmt::format("application program of {} ({}): {}; types and flags of {} communication objects may "
                                  "be missing",
                                  to_string(uses.front().device->address), base::printable(program), read.error().text,
                                  uses.size()));
    for (const auto& use : uses) complete(use, document);
  }

  void complete(const ObjectOfDevice& use, const ProgramDocument& program) {
    auto& object = *use.object;
    const bool own_text = !object.traits.text.empty();
    object.traits = over(object.traits, program.traits_of(object.id));
    if (own_text || object.traits.text.find("{{") == std::string::npos) return;
    std::vector<std::pair<std::string, std::string>> arguments;
    for (const auto& argument : use.device->arguments) {
      if (argument.module != object.module) continue;
      const auto id =
          argument.id.starts_with("M-") ? argument.id : fmt::format("{}_{}", use.device->program, argument.id);
      arguments.emplace_back(program.argument_name(id), argument.value);
    }
    object.traits.text = filled_text(object.traits.text, {}, arguments, true);
    if (!object.traits.text_parameter.empty() && object.traits.text.find("{{0") != std::string::npos) {
      waiting_.push_back(use);
      parameters_.want(use.device->id, parameter_of(object));
    }
  }

  /// As the instance has it: `..._MD-2_P-15_R-17` -> `..._MD-2_M-20_MI-1_P-15_R-17`.
  static std::string parameter_of(const LinkedObject& object) {
    auto id = object.traits.text_parameter;
    const auto definition = object.module.substr(0, object.module.find('_')) + "_";
    const auto at = object.module.empty() ? id.npos : id.find("_" + definition);
    if (at != id.npos) id.replace(at + 1, definition.size(), object.module + "_");
    return id;
  }

  void fill_parameters() {
    if (!parameters_.wants_nothing()) {
      if (const auto read = file_.read_part("0.xml", parameters_); !read) report_.warning(0, {}, read.error().text);
    }
    for (const auto& use : waiting_) {
      auto& text = use.object->traits.text;
      text = filled_text(text, parameters_.value_of(use.device->id, parameter_of(*use.object)), {}, false);
    }
  }

  const ProjectFile& file_;
  groups::Report& report_;
  std::vector<Device*> devices_;
  std::vector<ObjectOfDevice> waiting_;  ///< whose texts have the value of a parameter
  ParameterDocument parameters_;
};

}  // namespace

void complete_objects(const ProjectFile& file, std::vector<Installation>& installations, groups::Report& report) {
  Completion(file, installations, report).run();
}

std::string filled_text(std::string_view text, std::string_view parameter,
                        const std::vector<std::pair<std::string, std::string>>& arguments, bool keep_parameter) {
  std::string out;
  while (true) {
    const auto begin = std::min(text.find("{{"), text.size());
    const auto end = text.find("}}", begin);
    out += text.substr(0, begin);
    if (end == text.npos) return out + std::string(text.substr(begin));
    const auto place = text.substr(begin + 2, end - begin - 2);
    const auto colon = std::min(place.find(':'), place.size());
    const auto name = place.substr(0, colon);
    const auto argument =
        std::find_if(arguments.begin(), arguments.end(), [&](const auto& one) { return one.first == name; });
    if (argument != arguments.end()) {
      out += argument->second;
    } else if (name == "0" && keep_parameter) {
      out += text.substr(begin, end + 2 - begin);
    } else if (name == "0" && !parameter.empty()) {
      out += parameter;
    } else {
      out += place.substr(std::min(colon + 1, place.size()));
    }
    text.remove_prefix(end + 2);
  }
}

}  // namespace rubicon::networks::knx::project
