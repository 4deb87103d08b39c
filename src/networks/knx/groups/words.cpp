#include "networks/knx/groups/words.h"

#include <algorithm>
#include <optional>
#include <unordered_map>

#include "networks/knx/groups/encoding.h"

namespace rubicon::networks::knx::groups {

using enum Sense;

const std::vector<SenseOfWord> kWordTable{
    // English
    {"status", kState},
    {"state", kState},
    {"feedback", kState},
    {"fb", kState},
    {"report", kState},
    {"confirmation", kState},
    {"actual", kActual},
    {"current", kActual},
    {"command", kCommand},
    {"cmd", kCommand},
    {"control", kSwitch},
    {"switch", kSwitch},
    {"switching", kSwitch},
    {"on", kSwitch},
    {"off", kSwitch},
    {"set", kSwitch},
    {"setpoint", kSetpoint},
    {"target", kSetpoint},
    {"desired", kSetpoint},
    {"sensor", kMeasured},
    {"contact", kMeasured},
    {"detector", kMeasured},
    {"measured", kMeasured},
    {"leak", kMeasured},
    {"of", kFiller},
    {"the", kFiller},
    // German
    {"rückmeldung", kState},
    {"rueckmeldung", kState},
    {"rückm", kState},
    {"rm", kState},
    {"zustand", kState},
    {"statusmeldung", kState},
    {"statusrückmeldung", kState},
    {"schaltstatus", kState},
    {"schaltzustand", kState},
    {"aktuell-", kState},
    {"ist", kActual},
    {"istwert", kActual},
    {"stellung", kActual},
    {"schalten", kCommand},
    {"schalter", kSwitch},
    {"befehl", kCommand},
    {"steuern", kCommand},
    {"steuerung", kSwitch},
    {"setzen", kCommand},
    {"sperren", kCommand},
    {"ein", kSwitch},
    {"aus", kSwitch},
    {"an", kSwitch},
    {"soll", kSetpoint},
    {"sollwert", kSetpoint},
    {"-kontakt", kMeasured},
    {"-melder", kMeasured},
    {"-fühler", kMeasured},
    {"-sensor", kMeasured},
    {"-messung", kMeasured},
    {"leckage", kMeasured},
    {"von", kFiller},
    {"der", kFiller},
    // French
    {"état", kState},
    {"etat", kState},
    {"statut", kState},
    {"retour", kState},
    {"réel", kActual},
    {"mesuré", kMeasured},
    {"mesurée", kMeasured},
    {"actuel", kActual},
    {"actuelle", kActual},
    {"commande", kCommand},
    {"cde", kCommand},
    {"commutation", kSwitch},
    {"marche", kSwitch},
    {"arrêt", kSwitch},
    {"allumer", kCommand},
    {"consigne", kSetpoint},
    {"capteur", kMeasured},
    {"détecteur", kMeasured},
    {"fuite", kMeasured},
    {"d", kFiller},
    {"de", kFiller},
    {"du", kFiller},
    // Italian
    {"stato", kState},
    {"riscontro", kState},
    {"ritorno", kState},
    {"conferma", kState},
    {"attuale", kActual},
    {"comando", kCommand},
    {"accensione", kSwitch},
    {"accendi", kCommand},
    {"spegni", kCommand},
    {"impostazione", kSetpoint},
    {"impostata", kSetpoint},
    {"sensore", kMeasured},
    {"contatto", kMeasured},
    {"rilevatore", kMeasured},
    {"perdita", kMeasured},
    {"di", kFiller},
    {"del", kFiller},
    // Spanish
    {"estado", kState},
    {"realimentación", kState},
    {"realimentacion", kState},
    {"retorno", kState},
    {"confirmación", kState},
    {"actual", kActual},
    {"mando", kCommand},
    {"orden", kCommand},
    {"encender", kCommand},
    {"encendido", kSwitch},
    {"apagado", kSwitch},
    {"conmutación", kSwitch},
    {"consigna", kSetpoint},
    {"contacto", kMeasured},
    {"detector", kMeasured},
    {"fuga", kMeasured},
    // Dutch
    {"toestand", kState},
    {"terugmelding", kState},
    {"terugkoppeling", kState},
    {"stand", kActual},
    {"huidig", kActual},
    {"huidige", kActual},
    {"schakelen", kCommand},
    {"schakelaar", kSwitch},
    {"bediening", kSwitch},
    {"aansturing", kCommand},
    {"aan", kSwitch},
    {"uit", kSwitch},
    {"gewenst", kSetpoint},
    {"gewenste", kSetpoint},
    {"setpunt", kSetpoint},
    {"-contact", kMeasured},
    {"-voeler", kMeasured},
    {"lek", kMeasured},
    {"van", kFiller},
};

namespace {

bool is_word_byte(char c) {
  const auto byte = static_cast<unsigned char>(c);
  return byte >= 0x80 || (byte >= '0' && byte <= '9') || (byte >= 'a' && byte <= 'z');
}

std::optional<Sense> sense_of(std::string_view word) {
  static const auto kIndex = [] {
    std::unordered_map<std::string_view, Sense> index;
    for (const auto& entry : kWordTable) index.emplace(entry.word, entry.sense);
    return index;
  }();
  if (const auto found = kIndex.find(word); found != kIndex.end()) return found->second;
  for (const auto& [part, sense] : kWordTable) {
    if (part.starts_with('-') && word.ends_with(part.substr(1))) return sense;
    if (part.ends_with('-') && word.starts_with(part.substr(0, part.size() - 1))) return sense;
  }
  return {};
}

void append(std::string& out, std::string_view word) {
  if (!out.empty()) out += ' ';
  out += word;
}

}  // namespace

NameWords words_of(std::string_view name) {
  NameWords out;
  const auto small = to_lower(name);
  std::string_view text = small;
  while (!text.empty()) {
    const auto begin = static_cast<std::size_t>(std::find_if(text.begin(), text.end(), is_word_byte) - text.begin());
    text.remove_prefix(begin);
    const auto end = static_cast<std::size_t>(std::find_if_not(text.begin(), text.end(), is_word_byte) - text.begin());
    const auto word = text.substr(0, end);
    text.remove_prefix(end);
    if (word.empty()) break;
    const auto sense = sense_of(word);
    if (sense) out.has[static_cast<std::size_t>(*sense)] = true;
    if (sense && *sense != kFiller) append(out.shown, word);
    if (sense == kState || sense == kCommand || sense == kSwitch || sense == kFiller) continue;
    append(out.rest, word);
    if (sense != kActual && sense != kSetpoint) append(out.stem, word);
  }
  return out;
}

}  // namespace rubicon::networks::knx::groups
