#pragma once

#include "networks/knx/groups/group_list.h"
#include "networks/knx/project/installation.h"
#include "networks/knx/project/project_file.h"

namespace rubicon::networks::knx::project {

/// Completes the objects of the devices by what their application programs state, one program after the other, and the
/// places in their texts: `{{0:default}}` is the value of a parameter, `{{NAME}}` that of an argument of the module.
/// What cannot be read becomes a warning of the report. kOutOfRange: beyond the bound of the texts.
Result<void> complete_objects(const ProjectFile& file, std::vector<Installation>& installations, KeptTexts& texts,
                              groups::Report& report);

/// The text with its places filled: from the arguments (name, value); `{{0:default}}` from the parameter, else by the
/// default, unless it is kept for later.
std::string filled_text(std::string_view text, std::string_view parameter,
                        const std::vector<std::pair<std::string_view, std::string_view>>& arguments,
                        bool keep_parameter);

}  // namespace rubicon::networks::knx::project
