#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "apps/rubicon/island_findings.h"
#include "trust/trust.h"

namespace rubicon::cli {

// Trust and rights (docs/trust.md, docs/rights.md). Pure functions of what was observed, all of check `trust` but for
// `access` and `rights`.

/// What to do about a refusal, of this program or in the log of the other side; empty: trust is not the reason.
std::string_view trust_remedy(std::string_view reason);
/// The parts of reasons that trust_remedy() knows.
std::vector<std::string_view> trust_reasons();

/// How this program takes part: `own` as client::open_trust() gave it.
Findings check_own_trust(const Result<std::shared_ptr<rubicon::trust::Trust>>& own);

/// No island was found this way, but these were found the other way: `with_trust` is what this program tried first.
Findings check_other_side(const std::vector<client::Component>& islands, bool with_trust);

/// `silent` participants of the DDS domain showed no component. None: nothing to say.
Findings check_silent_participants(std::size_t silent, unsigned domain, bool with_trust);

bool has_refused_peers(const IslandSeen& seen);
/// The newest line about a peer that an island refused; nullopt: none.
std::optional<LogLine> last_refusal(const std::vector<LogLine>& lines);
/// The certificate of an island, and what and whom it refused.
Findings check_island_trust(const IslandSeen& seen);

/// `access`: who can read and command an island that this program found with trust; `on_peis`: it is on PEIS too.
Finding check_access_with_trust(const IslandSeen& seen, bool on_peis);

}  // namespace rubicon::cli
