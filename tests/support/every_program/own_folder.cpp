#include "support/meeting_folder.h"

namespace rubicon::support {

namespace {

/// No test meets programs of the host, or of another test.
const MeetingFolder own_folder;

}  // namespace

}  // namespace rubicon::support
