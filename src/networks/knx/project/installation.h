#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "networks/knx/wire/address.h"
#include "networks/knx/xml/xml_parser.h"

namespace rubicon::networks::knx::project {

/// What a communication object, a reference to it and its instance in a device may each state (knx.md, section 13.4).
/// Where one states nothing, the one below it counts: instance, reference, object.
struct ObjectTraits {
  std::optional<bool> communication{}, read{}, write{}, transmit{};
  std::string types{};  ///< `DPST-9-1 DPST-9-2`
  std::string size{};   ///< `1 Bit`, `2 Bytes`
  std::string text{}, function_text{};
  std::string text_parameter{};  ///< id of the parameter whose value is in the text
};

/// The traits in the attributes of an element.
ObjectTraits traits_of(const xml::Attributes& attributes);
/// The traits of `above`, and those of `below` where it states nothing.
ObjectTraits over(ObjectTraits above, const ObjectTraits& below);

/// A communication object of a device that is linked to group addresses.
struct LinkedObject {
  std::string id;       ///< of its reference in the program, without the part of a module: `M-0083_A-..._O-1_R-1`
  std::string module;   ///< `MD-2_M-20_MI-1`; empty = in no module
  std::string channel;  ///< empty = none
  ObjectTraits traits;
  std::vector<std::string> links;  ///< ids of group addresses; it sends to the first
};

/// A value that an instance of a module has for one of its arguments.
struct ModuleArgument {
  std::string module, id, value;
};

struct Device {
  wire::IndividualAddress address{};
  std::string id, name, description;
  std::string product;                     ///< ProductRefId
  std::string product_name, order_number;  ///< of the manufacturer
  std::string hardware_program, program;   ///< Hardware2ProgramRefId; the application that it names
  std::string room;                        ///< empty = in none, or only in a distribution board
  std::vector<LinkedObject> objects;
  std::vector<ModuleArgument> arguments;
};

/// A GroupAddress element.
struct ProjectAddress {
  std::string id;
  std::string number;  ///< as it is in the file, which may be wrong
  std::string name, description, types, main_group, middle_group, security;
  bool has_key = false, central = false, unfiltered = false;
  std::size_t line = 0;
};

/// A function of a building: addresses in their roles (`SwitchOnOff`, `InfoOnOff`).
struct Function {
  std::string id, name, type, room;
  struct Member {
    std::string address, role;
  };
  std::vector<Member> members;
};

/// One installation of a project. Ids are without the part `P-0242-0_` that all of them share.
struct Installation {
  std::vector<ProjectAddress> addresses;
  std::vector<Device> devices;
  std::vector<Function> functions;
};

}  // namespace rubicon::networks::knx::project
