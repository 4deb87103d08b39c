#pragma once

#include "history/store.h"

namespace rubicon::history {

Result<void> prepare_statements(sqlite::Database& database, StoreStatements& statements, bool has_areas);

}  // namespace rubicon::history
