#include "networks/knx/project/programs.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "base/text.h"
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

/// `1.1.5, 1.1.6 and 38 more devices`.
std::string devices_text(const std::vector<ObjectOfDevice>& uses) {
  constexpr std::size_t kShown = 5;
  std::vector<const Device*> devices;
  for (const auto& use : uses) {
    if (devices.empty() || devices.back() != use.device) devices.push_back(use.device);  // they come in order
  }
  std::string text;
  for (std::size_t i = 0; i < devices.size() && i < kShown; ++i) {
    const auto& address = devices[i]->address;
    text += fmt::format("{}{}", i == 0 ? "" : ", ", address ? to_string(*address) : "a device without an address");
  }
  if (devices.size() > kShown) text += fmt::format(" and {} more devices", devices.size() - kShown);
  return text;
}

/// An application program, or where none is named what should name it.
struct ProgramName {
  std::string_view program, hardware_program;
  auto operator<=>(const ProgramName&) const = default;

  /// ` (M-0083_A-...)`; empty if neither is known.
  std::string shown() const {
    const auto name = program.empty() ? hardware_program : program;
    return name.empty() ? std::string() : fmt::format(" ({})", base::printable(name));
  }
};

class Completion {
 public:
  Completion(const ProjectFile& file, std::vector<Installation>& installations, KeptTexts& texts,
             groups::Report& report)
      : file_(file), texts_(texts), report_(report), parameters_(texts) {
    for (auto& installation : installations) {
      for (auto& device : installation.devices) devices_.push_back(&device);
    }
  }

  void run() {
    read_hardware();
    std::map<ProgramName, std::vector<ObjectOfDevice>> programs;
    for (auto* device : devices_) {
      const ProgramName name{device->program, device->program.empty() ? device->hardware_program : std::string_view()};
      for (auto& object : device->objects) programs[name].push_back({device, &object});
    }
    for (const auto& [program, uses] : programs) {
      if (!texts_.is_exceeded()) read_program(program, uses);
    }
    fill_parameters();
  }

 private:
  void read_hardware() {
    std::map<std::string, std::vector<Device*>> manufacturers;
    for (auto* device : devices_) manufacturers[manufacturer_of(device->hardware_program)].push_back(device);
    for (const auto& [manufacturer, devices] : manufacturers) {
      if (manufacturer.empty()) continue;
      HardwareDocument hardware(texts_);
      for (const auto* device : devices) hardware.want(device->hardware_program);
      if (const auto read = file_.read_entry(manufacturer + "/Hardware.xml", hardware); !read)
        report_.warning(0, {}, fmt::format("devices of {}: {}", manufacturer, read.error().text));
      for (auto* device : devices) device->program = hardware.program_of(device->hardware_program);
    }
  }

  void read_program(const ProgramName& name, const std::vector<ObjectOfDevice>& uses) {
    ProgramDocument document(texts_);
    for (const auto& use : uses) {
      use.object->id = full_id(name.program, use.object->id);
      document.want(use.object->id);
    }
    want_arguments(name, uses, document);
    const auto read = read_document(name, document);
    if (!read)
      report_.warning(0, {},
                      fmt::format("application program of {}{}: {}; types and flags of {} communication objects may "
                                  "be missing",
                                  devices_text(uses), name.shown(), read.error().text, uses.size()));
    std::vector<ObjectOfDevice> unknown;
    for (const auto& use : uses) {
      if (!complete(use, document)) unknown.push_back(use);
    }
    if (read && !unknown.empty())
      report_.warning(0, {},
                      fmt::format("{} communication objects of {} are not in their application program{}: types and "
                                  "flags may be missing",
                                  unknown.size(), devices_text(unknown), name.shown()));
  }

  Result<void> read_document(const ProgramName& name, ProgramDocument& document) {
    if (name.program.empty())
      return fail(ErrorCode::kNotFound,
                  name.hardware_program.empty() ? "the project names none" : "not named in Hardware.xml");
    return file_.read_entry(fmt::format("{}/{}.xml", manufacturer_of(name.program), name.program), document);
  }

  /// An id of the program, which the project may have without the part of the program.
  std::string_view full_id(std::string_view program, std::string_view id) {
    return id.starts_with("M-") ? id : texts_.keep(fmt::format("{}_{}", program, id));
  }

  void want_arguments(const ProgramName& name, const std::vector<ObjectOfDevice>& uses, ProgramDocument& document) {
    const Device* last = nullptr;
    for (const auto& use : uses) {
      if (use.device == last) continue;
      last = use.device;
      for (auto& argument : use.device->arguments) {
        argument.id = full_id(name.program, argument.id);
        document.want_argument(argument.id);
      }
    }
  }

  /// False if the program does not have the object.
  bool complete(const ObjectOfDevice& use, const ProgramDocument& program) {
    auto& object = *use.object;
    const bool own_text = !object.traits.text.empty();
    const auto traits = program.traits_of(object.id);
    if (!traits) return false;
    object.traits = over(object.traits, *traits);
    if (own_text || object.traits.text.find("{{") == std::string_view::npos) return true;
    std::vector<std::pair<std::string_view, std::string_view>> arguments;
    for (const auto& argument : use.device->arguments) {
      if (argument.module == object.module) arguments.emplace_back(program.argument_name(argument.id), argument.value);
    }
    object.traits.text = texts_.keep(filled_text(object.traits.text, {}, arguments, true));
    if (!object.traits.text_parameter.empty() && object.traits.text.find("{{0") != std::string_view::npos) {
      waiting_.push_back(use);
      parameters_.want(use.device->id, parameter_of(object));
    }
    return true;
  }

  /// As the instance has it: `..._MD-2_P-15_R-17` -> `..._MD-2_M-20_MI-1_P-15_R-17`, and in a module of a module
  /// `..._MD-4_SM-1_P-15_R-17` -> `..._MD-4_M-15_MI-1_SM-1_M-1_MI-1-1-2_SM-1_P-15_R-17`.
  static std::string parameter_of(const LinkedObject& object) {
    std::string id(object.traits.text_parameter);
    const auto definition = fmt::format("_{}_", object.module.substr(0, object.module.find('_')));
    const auto at = object.module.empty() ? id.npos : id.find(definition);
    if (at != id.npos) id.replace(at, definition.size(), fmt::format("_{}_", object.module));
    return id;
  }

  void fill_parameters() {
    if (!parameters_.wants_nothing()) {
      if (const auto read = file_.read_part("0.xml", parameters_); !read) report_.warning(0, {}, read.error().text);
    }
    for (const auto& use : waiting_) {
      auto& text = use.object->traits.text;
      text = texts_.keep(filled_text(text, parameters_.value_of(use.device->id, parameter_of(*use.object)), {}, false));
    }
  }

  const ProjectFile& file_;
  KeptTexts& texts_;
  groups::Report& report_;
  std::vector<Device*> devices_;
  std::vector<ObjectOfDevice> waiting_;  ///< whose texts have the value of a parameter
  ParameterDocument parameters_;
};

}  // namespace

Result<void> complete_objects(const ProjectFile& file, std::vector<Installation>& installations, KeptTexts& texts,
                              groups::Report& report) {
  Completion(file, installations, texts, report).run();
  return texts.is_exceeded() ? Result<void>(fail(ErrorCode::kOutOfRange, texts.why())) : Result<void>();
}

std::string filled_text(std::string_view text, std::string_view parameter,
                        const std::vector<std::pair<std::string_view, std::string_view>>& arguments,
                        bool keep_parameter) {
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
