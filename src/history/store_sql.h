#pragma once

#include "history/store.h"

namespace rubicon::history {

Result<void> prepare_statements(sqlite::Database& database, StoreStatements& statements);

}  // namespace rubicon::history
