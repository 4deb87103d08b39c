#pragma once

// The tests of the tuple space run over each engine: here is the one of this program.
#ifdef RUBICON_OVER_DDS
#include "tuples/dds/dds_test_ecology.h"
namespace rubicon::tuples {
using TestEcology = dds::DdsTestEcology;
/// Components see each other as soon as they are there, or after a turn.
inline constexpr bool kMeetAtOnce = false;
}  // namespace rubicon::tuples
#elif defined(RUBICON_OVER_JOINED)
#include "tuples/joined/joined_test_ecology.h"
namespace rubicon::tuples {
using TestEcology = joined::JoinedTestEcology;
inline constexpr bool kMeetAtOnce = false;
}  // namespace rubicon::tuples
#elif defined(RUBICON_OVER_PEIS)
#include "tuples/peis/peis_test_ecology.h"
namespace rubicon::tuples {
using TestEcology = peis::PeisTestEcology;
inline constexpr bool kMeetAtOnce = false;
}  // namespace rubicon::tuples
#else
#include "tuples/memory/memory_ecology.h"
namespace rubicon::tuples {
using TestEcology = MemoryEcology;
inline constexpr bool kMeetAtOnce = true;
}  // namespace rubicon::tuples
#endif
