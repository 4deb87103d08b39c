#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "networks/knx/project/document.h"
#include "networks/knx/wire/address.h"
#include "networks/knx/xml/xml_parser.h"

namespace rubicon::networks::knx::project {

// Texts that are views belong to the KeptTexts of the project.

/// What a communication object, a reference to it and its instance in a device may each state (knx.md, section 13.4).
/// Where one states nothing, the one below it counts: instance, reference, object.
struct ObjectTraits {
  std::optional<bool> communication{}, read{}, write{}, transmit{};
  std::string_view types{};  ///< `DPST-9-1 DPST-9-2`
  std::string_view size{};   ///< `1 Bit`, `2 Bytes`
  std::string_view text{}, function_text{};
  std::string_view text_parameter{};  ///< id of the parameter whose value is in the text

  /// The flags say what the object does on the bus: those that matter are stated.
  bool flags_are_known() const;
};

/// The traits in the attributes of an element. KeptTexts::is_exceeded() if they are beyond the bound.
ObjectTraits traits_of(const xml::Attributes& attributes, KeptTexts& texts);
/// The same traits with texts that are kept in `texts`.
ObjectTraits kept_in(KeptTexts& texts, ObjectTraits traits);
/// The traits of `above`, and those of `below` where it states nothing.
ObjectTraits over(ObjectTraits above, const ObjectTraits& below);

/// A communication object of a device that is linked to group addresses.
struct LinkedObject {
  std::string_view id;       ///< of its reference in the program, without the part of a module: `M-0083_A-..._O-1_R-1`
  std::string_view module;   ///< `MD-2_M-20_MI-1`; empty = in no module
  std::string_view channel;  ///< empty = none
  ObjectTraits traits;
  std::vector<std::string_view> links;  ///< ids of group addresses; it sends to the first
};

/// A value that an instance of a module has for one of its arguments.
struct ModuleArgument {
  std::string_view module, id, value;
};

struct Device {
  std::optional<wire::IndividualAddress> address;  ///< nullopt: planned, but not yet loaded by ETS
  std::string_view id;
  std::string_view hardware_program;  ///< Hardware2ProgramRefId
  std::string_view program{};         ///< the application that it names; empty until complete_objects()
  std::string_view room{};            ///< empty = in none, or only in a distribution board
  std::vector<LinkedObject> objects{};
  std::vector<ModuleArgument> arguments{};
};

/// A GroupAddress element.
struct ProjectAddress {
  std::string_view id;
  std::string_view number;  ///< as it is in the file, which may be wrong
  std::string_view types, security;
  std::string name, description, main_group, middle_group;  ///< moved into the list
  bool has_key = false, central = false, unfiltered = false;
  std::size_t line = 0;
};

/// A function of a building: addresses in their roles (`SwitchOnOff`, `InfoOnOff`).
struct Function {
  std::string_view id, name, room;
  struct Member {
    std::string_view address, role;
  };
  std::vector<Member> members{};
};

/// One installation of a project. Ids are without the part `P-0242-0_` that all of them share.
struct Installation {
  std::string_view name{};
  std::vector<ProjectAddress> addresses{};
  std::vector<Device> devices{};
  std::vector<Function> functions{};
};

}  // namespace rubicon::networks::knx::project
