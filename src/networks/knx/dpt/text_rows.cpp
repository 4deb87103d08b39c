#include "networks/knx/dpt/catalogue.h"
#include "networks/knx/dpt/records.h"
#include "networks/knx/dpt/table.h"

namespace rubicon::networks::knx::dpt {

namespace {

using namespace catalogue;

// main, sub, name, meaning, unit, bits, minimum, maximum, step, sensor, actuator, form, words, record
constexpr Dpt kTextRows[] = {
    row(15, 0, "DPT_Access_Data", "entrance access", "", 32, 0, 0, 0, kRecord, kRecord, Form::kRecord, {},
        &kAccessRecord),
    row(16, 0, "DPT_String_ASCII", "text, 14 characters ASCII", "", 112, 0, 127, 0, kText, kText, Form::kText),
    row(16, 1, "DPT_String_8859_1", "text, 14 characters ISO 8859-1", "", 112, 0, 255, 0, kText, kText, Form::kText),
    row(17, 1, "DPT_SceneNumber", "scene number", "", 8, 0, 63, 1, kScene, kScene, Form::kScene),
    row(18, 1, "DPT_SceneControl", "scene control", "", 8, 0, 0, 0, kRecord, kRecord, Form::kRecord, {},
        &kSceneControlRecord),
    row(19, 1, "DPT_DateTime", "date and time", "", 64, 0, 0, 0, kDateTime, kDateTime, Form::kDateTime),
};

}  // namespace

std::span<const Dpt> text_rows() {
  return kTextRows;
}

}  // namespace rubicon::networks::knx::dpt
