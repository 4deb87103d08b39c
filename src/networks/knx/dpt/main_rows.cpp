#include "networks/knx/dpt/bit_words.h"
#include "networks/knx/dpt/records.h"
#include "networks/knx/dpt/table.h"

namespace rubicon::networks::knx::dpt {

namespace {

using namespace catalogue;

constexpr Word kBits24[] = {{0, "bit 0"},   {1, "bit 1"},   {2, "bit 2"},   {3, "bit 3"},   {4, "bit 4"},
                            {5, "bit 5"},   {6, "bit 6"},   {7, "bit 7"},   {8, "bit 8"},   {9, "bit 9"},
                            {10, "bit 10"}, {11, "bit 11"}, {12, "bit 12"}, {13, "bit 13"}, {14, "bit 14"},
                            {15, "bit 15"}, {16, "bit 16"}, {17, "bit 17"}, {18, "bit 18"}, {19, "bit 19"},
                            {20, "bit 20"}, {21, "bit 21"}, {22, "bit 22"}, {23, "bit 23"}};

// main, sub, name, meaning, unit, bits, minimum, maximum, step, sensor, actuator, form, words, record
constexpr Dpt kMainRows[] = {
    bit(1, DptId::kMainOnly, "DPT_1", "main type 1", kBinaryState, kSwitchWords),
    row(2, DptId::kMainOnly, "DPT_2", "main type 2", "", 2, 0, 0, 0, kRecord, kRecord, Form::kRecord, kSwitchWords,
        &kControlRecord),
    row(3, DptId::kMainOnly, "DPT_3", "main type 3", "", 4, 0, 15, 1, kUnsigned4BitInput, kUnsigned4BitOutput,
        Form::kUnsigned),
    row(4, DptId::kMainOnly, "DPT_4", "main type 4", "", 8, 0, 255, 0, kText, kText, Form::kCharacter),
    row(5, DptId::kMainOnly, "DPT_5", "main type 5", "", 8, 0, 255, 1, kUnsigned8BitInput, kUnsigned8BitOutput,
        Form::kUnsigned),
    row(6, DptId::kMainOnly, "DPT_6", "main type 6", "", 8, -128, 127, 1, kSigned8BitInput, kSigned8BitOutput,
        Form::kSigned),
    row(7, DptId::kMainOnly, "DPT_7", "main type 7", "", 16, 0, 65535, 1, kUnsigned16BitInput, kUnsigned16BitOutput,
        Form::kUnsigned),
    row(8, DptId::kMainOnly, "DPT_8", "main type 8", "", 16, -32768, 32767, 1, kSigned16BitInput, kSigned16BitOutput,
        Form::kSigned),
    row(9, DptId::kMainOnly, "DPT_9", "main type 9", "", 16, kFloat16Minimum, kFloat16Maximum, 0, kFloat16BitInput,
        kFloat16BitOutput, Form::kFloat16),
    row(10, DptId::kMainOnly, "DPT_10", "main type 10", "", 24, 0, 0, 0, kTimeOfDay, kTimeOfDay, Form::kTime),
    row(11, DptId::kMainOnly, "DPT_11", "main type 11", "", 24, 0, 0, 0, kDate, kDate, Form::kDate),
    row(12, DptId::kMainOnly, "DPT_12", "main type 12", "", 32, 0, 4294967295, 1, kUnsigned32BitInput,
        kUnsigned32BitOutput, Form::kUnsigned),
    row(13, DptId::kMainOnly, "DPT_13", "main type 13", "", 32, -2147483648, 2147483647, 1, kSigned32BitInput,
        kSigned32BitOutput, Form::kSigned),
    row(14, DptId::kMainOnly, "DPT_14", "main type 14", "", 32, -kFloat32Maximum, kFloat32Maximum, 0, kFloat32BitInput,
        kFloat32BitOutput, Form::kFloat32),
    row(15, DptId::kMainOnly, "DPT_15", "main type 15", "", 32, 0, 0, 0, kRecord, kRecord, Form::kRecord, {},
        &kAccessRecord),
    row(16, DptId::kMainOnly, "DPT_16", "main type 16", "", 112, 0, 255, 0, kText, kText, Form::kText),
    row(17, DptId::kMainOnly, "DPT_17", "main type 17", "", 8, 0, 63, 1, kScene, kScene, Form::kScene),
    row(18, DptId::kMainOnly, "DPT_18", "main type 18", "", 8, 0, 0, 0, kRecord, kRecord, Form::kRecord, {},
        &kSceneControlRecord),
    row(19, DptId::kMainOnly, "DPT_19", "main type 19", "", 64, 0, 0, 0, kDateTime, kDateTime, Form::kDateTime),
    row(20, DptId::kMainOnly, "DPT_20", "main type 20", "", 8, 0, 255, 1, kEnumerationInput, kEnumerationOutput,
        Form::kEnumeration),
    row(21, DptId::kMainOnly, "DPT_21", "main type 21", "", 8, 0, 0, 0, kBitsetInput, kBitsetOutput, Form::kBits,
        std::span(kBits24).first(8)),
    row(22, DptId::kMainOnly, "DPT_22", "main type 22", "", 16, 0, 0, 0, kBitsetInput, kBitsetOutput, Form::kBits,
        std::span(kBits24).first(16)),
    row(23, DptId::kMainOnly, "DPT_23", "main type 23", "", 2, 0, 3, 1, kEnumerationInput, kEnumerationOutput,
        Form::kEnumeration),
    row(24, DptId::kMainOnly, "DPT_24", "main type 24", "", 0, 0, 255, 0, kText, kText, Form::kLongText),
    row(25, DptId::kMainOnly, "DPT_25", "main type 25", "", 8, 0, 0, 0, kRecord, kRecord, Form::kRecord, {},
        &kRepetitionsRecord),
    row(26, DptId::kMainOnly, "DPT_26", "main type 26", "", 8, 0, 0, 0, kRecord, kRecord, Form::kRecord, {},
        &kSceneStateRecord),
    row(27, DptId::kMainOnly, "DPT_27", "main type 27", "", 32, 0, 0, 0, kRecord, kRecord, Form::kRecord, {},
        &kCombinedOnOffRecord),
    row(28, DptId::kMainOnly, "DPT_28", "main type 28", "", 0, 0, 0x10ffff, 0, kText, kText, Form::kLongText),
    row(29, DptId::kMainOnly, "DPT_29", "main type 29", "", 64, -9223372036854775808.0, 9223372036854775808.0, 1,
        kSigned64BitInput, kSigned64BitOutput, Form::kSigned),
    row(30, DptId::kMainOnly, "DPT_30", "main type 30", "", 24, 0, 0, 0, kBitsetInput, kBitsetOutput, Form::kBits,
        kBits24),
    row(206, DptId::kMainOnly, "DPT_206", "main type 206", "", 24, 0, 0, 0, kRecord, kRecord, Form::kRaw),
    row(207, DptId::kMainOnly, "DPT_207", "main type 207", "", 16, 0, 0, 0, kRecord, kRecord, Form::kRaw),
    row(213, DptId::kMainOnly, "DPT_213", "main type 213", "", 64, 0, 0, 0, kRecord, kRecord, Form::kRaw),
    row(217, DptId::kMainOnly, "DPT_217", "main type 217", "", 16, 0, 0, 0, kRecord, kRecord, Form::kRaw),
    row(219, DptId::kMainOnly, "DPT_219", "main type 219", "", 48, 0, 0, 0, kRecord, kRecord, Form::kRaw),
    row(221, DptId::kMainOnly, "DPT_221", "main type 221", "", 48, 0, 0, 0, kRecord, kRecord, Form::kRaw),
    row(222, DptId::kMainOnly, "DPT_222", "main type 222", "", 48, 0, 0, 0, kRecord, kRecord, Form::kRaw),
    row(225, DptId::kMainOnly, "DPT_225", "main type 225", "", 24, 0, 0, 0, kRecord, kRecord, Form::kRaw),
    row(229, DptId::kMainOnly, "DPT_229", "main type 229", "", 48, 0, 0, 0, kRecord, kRecord, Form::kRaw),
    row(230, DptId::kMainOnly, "DPT_230", "main type 230", "", 64, 0, 0, 0, kRecord, kRecord, Form::kRaw),
    row(231, DptId::kMainOnly, "DPT_231", "main type 231", "", 32, 0, 0, 0, kRecord, kRecord, Form::kRaw),
    row(232, DptId::kMainOnly, "DPT_232", "main type 232", "", 24, 0, 0, 0, kRecord, kRecord, Form::kRaw),
    row(234, DptId::kMainOnly, "DPT_234", "main type 234", "", 16, 0, 0, 0, kRecord, kRecord, Form::kRaw),
    row(235, DptId::kMainOnly, "DPT_235", "main type 235", "", 48, 0, 0, 0, kRecord, kRecord, Form::kRaw),
    row(236, DptId::kMainOnly, "DPT_236", "main type 236", "", 8, 0, 0, 0, kRecord, kRecord, Form::kRaw),
    row(237, DptId::kMainOnly, "DPT_237", "main type 237", "", 16, 0, 0, 0, kRecord, kRecord, Form::kRaw),
    row(238, DptId::kMainOnly, "DPT_238", "main type 238", "", 8, 0, 0, 0, kRecord, kRecord, Form::kRaw),
    row(239, DptId::kMainOnly, "DPT_239", "main type 239", "", 16, 0, 0, 0, kRecord, kRecord, Form::kRaw),
    row(240, DptId::kMainOnly, "DPT_240", "main type 240", "", 24, 0, 0, 0, kRecord, kRecord, Form::kRaw),
    row(241, DptId::kMainOnly, "DPT_241", "main type 241", "", 32, 0, 0, 0, kRecord, kRecord, Form::kRaw),
    row(242, DptId::kMainOnly, "DPT_242", "main type 242", "", 48, 0, 0, 0, kRecord, kRecord, Form::kRaw),
    row(243, DptId::kMainOnly, "DPT_243", "main type 243", "", 64, 0, 0, 0, kRecord, kRecord, Form::kRaw),
    row(244, DptId::kMainOnly, "DPT_244", "main type 244", "", 16, 0, 0, 0, kRecord, kRecord, Form::kRaw),
    row(245, DptId::kMainOnly, "DPT_245", "main type 245", "", 48, 0, 0, 0, kRecord, kRecord, Form::kRaw),
    row(246, DptId::kMainOnly, "DPT_246", "main type 246", "", 16, 0, 0, 0, kRecord, kRecord, Form::kRaw),
    row(249, DptId::kMainOnly, "DPT_249", "main type 249", "", 48, 0, 0, 0, kRecord, kRecord, Form::kRaw),
    row(250, DptId::kMainOnly, "DPT_250", "main type 250", "", 24, 0, 0, 0, kRecord, kRecord, Form::kRaw),
    row(251, DptId::kMainOnly, "DPT_251", "main type 251", "", 48, 0, 0, 0, kRecord, kRecord, Form::kRaw),
    row(252, DptId::kMainOnly, "DPT_252", "main type 252", "", 40, 0, 0, 0, kRecord, kRecord, Form::kRaw),
    row(253, DptId::kMainOnly, "DPT_253", "main type 253", "", 32, 0, 0, 0, kRecord, kRecord, Form::kRaw),
    row(254, DptId::kMainOnly, "DPT_254", "main type 254", "", 24, 0, 0, 0, kRecord, kRecord, Form::kRaw),
    row(255, DptId::kMainOnly, "DPT_255", "main type 255", "", 64, 0, 0, 0, kRecord, kRecord, Form::kRaw),
    row(275, DptId::kMainOnly, "DPT_275", "main type 275", "", 64, 0, 0, 0, kRecord, kRecord, Form::kRaw),
    row(285, DptId::kMainOnly, "DPT_285", "main type 285", "", 128, 0, 0, 0, kRecord, kRecord, Form::kRaw),
};

}  // namespace

std::span<const Dpt> main_rows() {
  return kMainRows;
}

namespace {

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
