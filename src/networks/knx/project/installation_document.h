#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "networks/knx/project/document.h"
#include "networks/knx/project/installation.h"

namespace rubicon::networks::knx::project {

/// The id in the application program of what is in an instance of a module, or of a module in a module:
/// `MD-2_M-20_MI-1_O-2_R-3` -> `MD-2_O-2_R-3`, and `MD-4_M-15_MI-1_SM-1_M-1_MI-1-1-2_SM-1_O-3_R-2` ->
/// `MD-4_SM-1_O-3_R-2`. `module` becomes the instance: `MD-2_M-20_MI-1`; it stays as it is for other ids (knx.md,
/// section 21.9).
std::string without_module(std::string_view id, std::string& module);

/// Bounds of one project: a file beyond them is refused.
inline constexpr std::size_t kMaxDevices = 65'536, kMaxSpaces = 65'536, kMaxObjects = 200'000, kMaxLinks = 500'000,
                             kMaxFunctions = 65'536, kMaxMembers = 200'000, kMaxArguments = 500'000;

/// `0.xml`: addresses, devices with the objects that are linked, rooms and functions. Keys and passwords in it are not
/// kept.
class InstallationDocument final : public KeepingDocument {
 public:
  explicit InstallationDocument(KeptTexts& texts) : KeepingDocument(texts) {}

  void start(std::string_view name, const xml::Attributes& attributes) override;
  void end(std::string_view name) override;

  /// All installations. A group address beyond 65,535 of them is left out and counted.
  std::vector<Installation> take() { return std::move(installations_); }
  std::size_t addresses_left_out() const { return left_out_; }

 private:
  struct Space {
    std::string name;
    bool board = false;  ///< a distribution board is not the room of the things that its devices control
  };
  /// The rooms of buildings get the names of these if there are several.
  struct Place {
    std::string_view building, room;
  };
  using Start = void (InstallationDocument::*)(const xml::Attributes& attributes);
  using End = void (InstallationDocument::*)();

  bool bounded(std::size_t& count, std::size_t most, std::string_view what);
  Installation& here();
  void start_installation(const xml::Attributes& attributes);
  void start_area(const xml::Attributes& attributes) { area_ = short_text(attributes, "Address"); }
  void start_line(const xml::Attributes& attributes) { line_ = short_text(attributes, "Address"); }
  void start_device(const xml::Attributes& attributes);
  void end_device();
  void start_object(const xml::Attributes& attributes);
  void end_object();
  void link(std::string_view id);
  void start_link(const xml::Attributes& attributes);
  void start_module(const xml::Attributes& attributes) { module_ = keep(attributes, "Id"); }
  void end_module() { module_ = {}; }
  void add_argument(const xml::Attributes& attributes);
  void start_range(const xml::Attributes& attributes);
  void end_range();
  void start_address(const xml::Attributes& attributes);
  void start_space(const xml::Attributes& attributes);
  void end_space();
  void place_device(const xml::Attributes& attributes);
  void start_function(const xml::Attributes& attributes);
  void end_function() { in_function_ = false; }
  void add_member(const xml::Attributes& attributes);
  void end_installation();
  Place place();
  std::string_view room_of(const Place& place);

  std::vector<Installation> installations_;
  std::string area_, line_;
  bool in_device_ = false, in_object_ = false, in_function_ = false;
  LinkedObject object_;
  std::optional<KeptTexts> object_texts_;  ///< of object_, until it is known to be linked
  std::string_view module_;                ///< the instance of a module whose arguments come
  std::vector<std::string> ranges_;
  std::vector<Space> spaces_;
  std::size_t buildings_ = 0;                   ///< the number of the one that spaces_ are in
  std::optional<std::size_t> building_in_use_;  ///< the first that has devices or functions
  bool several_buildings_ = false;
  std::unordered_map<std::string_view, Place> device_places_;
  std::vector<Place> function_places_;  ///< of the functions of the installation
  std::size_t left_out_ = 0, addresses_ = 0, devices_ = 0, objects_ = 0, links_ = 0, space_count_ = 0, functions_ = 0,
              members_ = 0, arguments_ = 0;
};

/// `P-0242-0_GA-6` and `GA-6` -> `GA-6`.
std::string_view short_id(std::string_view id);

}  // namespace rubicon::networks::knx::project
