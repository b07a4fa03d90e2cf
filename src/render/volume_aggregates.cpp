#include "render/volume_aggregates.h"

#include <algorithm>

#include "render/world_lights.h"
#include "trace/world.h"

namespace kinora::render {

namespace {

constexpr const char* kGlobal = "globalVolumeAggregate";  // that of objects which name none

bool has(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}
void add(std::vector<std::string>& names, const std::string& name) {
  if (!has(names, name)) names.push_back(name);
}
std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& n : names) text += (text.empty() ? "'" : ", '") + n + "'";
  return text;
}

}  // namespace

AggregateChoice aggregatesOf(const Descriptor& integrator, const scene::Node* node) {
  AggregateChoice choice;
  if (node) choice.pos = node->pos;
  const bool isOwn = node && node->plugin == integrator.name;
  const auto find = [&](const char* name, std::vector<std::string>& names) {
    for (uint32_t k = 0; k < integrator.paramCount; ++k) {
      const Param& p = integrator.params[k];
      if (p.type != Type::String || std::string(p.name) != name) continue;
      const scene::Parameter* said = isOwn ? node->params.find(p.name) : nullptr;
      if (!said) names = groupNames(p.text);
      for (size_t i = 0; said && i < said->strings.size(); ++i)
        for (const std::string& n : groupNames(said->strings[i])) add(names, n);
      return true;
    }
    return false;
  };
  std::vector<std::string> all;
  choice.isMade = find("volumeAggregate", all);
  if (!choice.isMade) return choice;
  for (auto& [name, names] :
       {std::pair("volumeAggregateCamera", &choice.camera), std::pair("volumeAggregateIndirect", &choice.indirect),
        std::pair("volumeAggregateTransmission", &choice.transmission)})
    if (!find(name, *names) || names->empty()) *names = all;
  return choice;
}

uint32_t Aggregates::visibilityOf(const scene::Attributes* attributes, uint32_t visibility,
                                  const std::string& object) {
  if (!choice_.isMade) return visibility;
  const scene::Parameter* said = attributes ? attributes->named.find("volume:aggregate") : nullptr;
  std::vector<std::string> own;
  if (said)
    for (const std::string& text : said->strings)
      for (const std::string& name : groupNames(text)) add(own, name);
  else
    own.push_back(kGlobal);
  if (own.empty()) return visibility;  // in none: a medium on its own
  for (const std::string& name : own) add(met_, name);
  const auto isIn = [&](const std::vector<std::string>& names) {
    // files of when no object was in an aggregate unless it said so ask for none
    return names.empty() ? !said
                         : std::any_of(own.begin(), own.end(), [&](const std::string& n) { return has(names, n); });
  };
  uint32_t asked = 0;
  if (!interiors_.empty() && isIn(interiors_)) asked = ~0u;
  if (isIn(choice_.camera)) asked |= trace::kSeenByCamera;
  if (isIn(choice_.indirect)) asked |= trace::kSeenByIndirect;
  if (isIn(choice_.transmission)) asked |= trace::kSeenByOpaqueShadow | trace::kSeenByClearShadow;
  if (!asked) {
    for (const std::string& name : own) add(unseen_, name);
    if (++unseenCount_ <= 3) firstUnseen_.push_back(object);
  }
  const bool respects = !attributes || attributes->getInt("volume:aggregaterespectvisibility", 1);
  return respects ? asked & visibility : asked;
}

void Aggregates::tell(Diagnostics& diagnostics) const {
  if (!choice_.isMade) return;
  std::vector<std::string> unknown;
  for (const auto* names : {&choice_.camera, &choice_.indirect, &choice_.transmission, &interiors_})
    for (const std::string& name : *names)
      if (name != kGlobal && !has(met_, name)) add(unknown, name);
  for (const std::string& name : unknown) {
    diagnostics.warning("MEDIUM-AGGREGATE", choice_.pos,
                        "no volume is in the aggregate '" + name + "' that is asked for",
                        "rays that ask for it know of none by that name",
                        met_.empty() ? "Attribute \"volume\" \"string aggregate\" puts volumes into one"
                                     : "there are " + listed(met_));
  }
  if (!unseenCount_) return;
  diagnostics.warning("MEDIUM-LEFT-OUT", choice_.pos,
                      std::to_string(unseenCount_) + (unseenCount_ == 1 ? " volume (" : " volumes (") +
                          listed(firstUnseen_) + (unseenCount_ > firstUnseen_.size() ? ", ..." : "") +
                          (unseenCount_ == 1 ? ") is" : ") are") +
                          " in aggregates that the integrator asks for in no ray: " + listed(unseen_),
                      unseenCount_ == 1 ? "it is left out" : "they are left out",
                      "volumeAggregate of the integrator names aggregates, several with blanks between them");
}

}  // namespace kinora::render
