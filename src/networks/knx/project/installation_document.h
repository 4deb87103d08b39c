#pragma once

#include <unordered_map>
#include <vector>

#include "networks/knx/project/document.h"
#include "networks/knx/project/installation.h"

namespace rubicon::networks::knx::project {

/// Bounds of one project: a file beyond them is refused.
inline constexpr std::size_t kMaxDevices = 65'536, kMaxSpaces = 65'536, kMaxObjects = 200'000, kMaxLinks = 500'000,
                             kMaxFunctions = 65'536, kMaxMembers = 200'000, kMaxArguments = 500'000;
/// Bytes of the names and descriptions of all group addresses and of the groups they are in, and of the texts of
/// objects.
inline constexpr std::size_t kMaxTexts = std::size_t{64} << 20U;

/// `0.xml`: addresses, devices with the objects that are linked, rooms and functions. Keys and passwords in it are not
/// kept.
class InstallationDocument final : public Document {
 public:
  void start(std::string_view name, const xml::Attributes& attributes) override;
  void end(std::string_view name) override;

  /// All installations. A group address beyond 65,535 of them is left out and counted.
  std::vector<Installation> take() { return std::move(installations_); }
  std::size_t addresses_left_out() const { return left_out_; }

 private:
  struct Space {
    std::string name;
    bool board = false;  ///< a distribution board is no room of what its devices control
  };

  bool bounded(std::size_t& count, std::size_t most, std::string_view what);
  Installation& here();
  void keep(std::size_t bytes);
  void start_device(const xml::Attributes& attributes);
  void start_object(const xml::Attributes& attributes);
  void end_object();
  void link(std::string_view id);
  void start_address(const xml::Attributes& attributes);
  void start_space(const xml::Attributes& attributes);
  void place_device(const xml::Attributes& attributes);
  void start_function(const xml::Attributes& attributes);
  void add_member(const xml::Attributes& attributes);
  void end_installation();
  std::string room() const;

  std::vector<Installation> installations_;
  std::string area_, line_;
  bool in_device_ = false, in_object_ = false, in_function_ = false;
  LinkedObject object_;
  std::string module_;  ///< the instance of a module whose arguments come
  std::vector<std::string> ranges_;
  std::vector<Space> spaces_;
  std::unordered_map<std::string, std::string> rooms_;  ///< by device
  std::size_t left_out_ = 0, addresses_ = 0, devices_ = 0, objects_ = 0, links_ = 0, space_count_ = 0, functions_ = 0,
              members_ = 0, arguments_ = 0, texts_ = 0;
};

/// `P-0242-0_GA-6` and `GA-6` -> `GA-6`.
std::string_view short_id(std::string_view id);

}  // namespace rubicon::networks::knx::project
