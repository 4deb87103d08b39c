#include "model/type_tables.h"

namespace rubicon::model {

namespace {

using enum DataType;
using enum Report;

// id, name, quantity, unit, data, minimum, maximum, report, words
constexpr Type kRegisterTypes[] = {
    {TypeId(0x0100), "digitalInput", "digital input", "1", kBoolean, -kNone, kNone, kState, ""},
    {TypeId(0x0101), "analogueInput", "analogue input", "1", kReal, -kNone, kNone, kState, ""},
    {TypeId(0x0102), "unsigned1BitInput", "input register", "1", kInteger, 0.0, 1.0, kState, ""},
    {TypeId(0x0103), "unsigned2BitInput", "input register", "1", kInteger, 0.0, 3.0, kState, ""},
    {TypeId(0x0104), "unsigned4BitInput", "input register", "1", kInteger, 0.0, 15.0, kState, ""},
    {TypeId(0x0105), "unsigned8BitInput", "input register", "1", kInteger, 0.0, 255.0, kState, ""},
    {TypeId(0x0106), "unsigned16BitInput", "input register", "1", kInteger, 0.0, 65535.0, kState, ""},
    {TypeId(0x0107), "unsigned24BitInput", "input register", "1", kInteger, 0.0, 16777215.0, kState, ""},
    {TypeId(0x0108), "unsigned32BitInput", "input register", "1", kInteger, 0.0, 4294967295.0, kState, ""},
    {TypeId(0x0109), "unsigned64BitInput", "input register", "1", kInteger, 0.0, kNone, kState, ""},
    {TypeId(0x010a), "signed8BitInput", "input register", "1", kInteger, -128.0, 127.0, kState, ""},
    {TypeId(0x010b), "signed16BitInput", "input register", "1", kInteger, -32768.0, 32767.0, kState, ""},
    {TypeId(0x010c), "signed32BitInput", "input register", "1", kInteger, -2147483648.0, 2147483647.0, kState, ""},
    {TypeId(0x010d), "signed64BitInput", "input register", "1", kInteger, -kNone, kNone, kState, ""},
    {TypeId(0x010e), "float16BitInput", "input register", "1", kReal, -671088.64, 670433.28, kState, ""},
    {TypeId(0x010f), "float32BitInput", "input register", "1", kReal, -kNone, kNone, kState, ""},
    {TypeId(0x0110), "textInput", "input text", "1", kText, -kNone, kNone, kState, ""},
    {TypeId(0x0111), "bytesInput", "input bytes", "1", kBytes, -kNone, kNone, kState, ""},
    {TypeId(0x0112), "structuredInput", "input record", "1", kJson, -kNone, kNone, kState, ""},
    {TypeId(0x0113), "enumerationInput", "input code", "1", kEnumeration, 0.0, 65535.0, kState, ""},
    {TypeId(0x0114), "bitsetInput", "input flags", "1", kJson, -kNone, kNone, kState, ""},
    {TypeId(0x0140), "digitalOutput", "digital output", "1", kBoolean, -kNone, kNone, kState, ""},
    {TypeId(0x0141), "analogueOutput", "analogue output", "1", kReal, -kNone, kNone, kState, ""},
    {TypeId(0x0142), "unsigned1BitOutput", "output register", "1", kInteger, 0.0, 1.0, kState, ""},
    {TypeId(0x0143), "unsigned2BitOutput", "output register", "1", kInteger, 0.0, 3.0, kState, ""},
    {TypeId(0x0144), "unsigned4BitOutput", "output register", "1", kInteger, 0.0, 15.0, kState, ""},
    {TypeId(0x0145), "unsigned8BitOutput", "output register", "1", kInteger, 0.0, 255.0, kState, ""},
    {TypeId(0x0146), "unsigned16BitOutput", "output register", "1", kInteger, 0.0, 65535.0, kState, ""},
    {TypeId(0x0147), "unsigned24BitOutput", "output register", "1", kInteger, 0.0, 16777215.0, kState, ""},
    {TypeId(0x0148), "unsigned32BitOutput", "output register", "1", kInteger, 0.0, 4294967295.0, kState, ""},
    {TypeId(0x0149), "unsigned64BitOutput", "output register", "1", kInteger, 0.0, kNone, kState, ""},
    {TypeId(0x014a), "signed8BitOutput", "output register", "1", kInteger, -128.0, 127.0, kState, ""},
    {TypeId(0x014b), "signed16BitOutput", "output register", "1", kInteger, -32768.0, 32767.0, kState, ""},
    {TypeId(0x014c), "signed32BitOutput", "output register", "1", kInteger, -2147483648.0, 2147483647.0, kState, ""},
    {TypeId(0x014d), "signed64BitOutput", "output register", "1", kInteger, -kNone, kNone, kState, ""},
    {TypeId(0x014e), "float16BitOutput", "output register", "1", kReal, -671088.64, 670433.28, kState, ""},
    {TypeId(0x014f), "float32BitOutput", "output register", "1", kReal, -kNone, kNone, kState, ""},
    {TypeId(0x0150), "textOutput", "output text", "1", kText, -kNone, kNone, kState, ""},
    {TypeId(0x0151), "bytesOutput", "output bytes", "1", kBytes, -kNone, kNone, kState, ""},
    {TypeId(0x0152), "structuredOutput", "output record", "1", kJson, -kNone, kNone, kState, ""},
    {TypeId(0x0153), "enumerationOutput", "output code", "1", kEnumeration, 0.0, 65535.0, kState, ""},
    {TypeId(0x0154), "bitsetOutput", "output flags", "1", kJson, -kNone, kNone, kState, ""},
};

}  // namespace

std::span<const Type> register_types() {
  return kRegisterTypes;
}

}  // namespace rubicon::model
