#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "support/folder.h"
#include "trust/now.h"
#include "trust/site/site_issuer.h"
#include "trust/site/site_operations.h"

namespace rubicon::trust::site {

/// A realm of brokers in a folder, and the folder of another host.
class SiteRealms : public testing::Test {
 protected:
  SiteRealms() {
    const auto made = init(home_, {"Rubicon", {"broker.test"}}, kNow);
    EXPECT_TRUE(made) << made.error().text;
  }

  SiteRealm realm(const std::filesystem::path& folder) const {
    const SiteFolder opened(folder);
    const auto authority = opened.authority(kNow);
    if (!authority) throw std::runtime_error(authority.error().text);
    auto read = opened.realm(*authority);
    if (!read) throw std::runtime_error(read.error().text);
    return std::move(*read);
  }
  SiteIssued added(const std::string& name, const std::vector<std::string>& roles = {},
                   const std::vector<OwnerId>& islands = {}) const {
    auto issued = add(home_, {name, islands, roles, 100}, kNow);
    if (!issued) throw std::runtime_error(issued.error().text);
    return std::move(*issued);
  }
  Error refused(const SiteMemberOptions& options) const {
    const auto issued = add(home_, options, kNow);
    return issued ? Error{} : issued.error();
  }
  static std::string mode_of(const std::string& path) {
    namespace fs = std::filesystem;
    std::error_code error;
    const auto about = fs::status(path, error);
    return error ? "absent" : fmt::format("{:o}", static_cast<unsigned>(about.permissions()));
  }

  const support::Folder folder_;
  const std::filesystem::path home_ = folder_ / "home";
  const std::filesystem::path away_ = folder_ / "away";
};

}  // namespace rubicon::trust::site
