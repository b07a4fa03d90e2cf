#include "film/light_paths.h"

#include <algorithm>
#include <cctype>
#include <utility>

#include "base/text.h"

namespace kinora::film {

namespace {

// The standard set: from "emissive" to "volume" they are disjoint and hold every path, so they sum to beauty.
struct Named {
  const char* name;
  const char* expression;
};
constexpr Named kNamed[] = {
    {"Ci", "C[DS]*[<L.>O]"},
    {"beauty", "C[DS]*[<L.>O]"},
    {"emissive", "C[<L.>O]"},
    {"emission", "C[<L.>O]"},
    {"diffuse", "C<RD>[<L.>O]"},
    {"directDiffuse", "C<RD>[<L.>O]"},
    {"indirectDiffuse", "C<RD>[DS]+[<L.>O]"},
    {"specular", "C<RS>[<L.>O]"},
    {"directSpecular", "C<RS>[<L.>O]"},
    {"indirectSpecular", "C<RS>[DS]+[<L.>O]"},
    {"subsurface", "C<TD>[DS]*[<L.>O]"},
    {"transmissive", "C<TS>[DS]*[<L.>O]"},
    {"refraction", "C<TS>[DS]*[<L.>O]"},
    {"volume", "C<V.>[DS]*[<L.>O]"},
    {"direct", "C[DS]?[<L.>O]"},
    {"indirect", "C[DS]{2,}[<L.>O]"},
    {"caustics", "CD[S]+<L.>"},
    {"shadowCollector", "shadows;C[<.D'collector'><.S'collector'>]<L.>"},
    {"reflectionCollector", "C<RS'collector'>([DS]+<L.>|[DS]*O)"},
};

const char* namedExpression(std::string_view name) {
  for (const Named& n : kNamed)
    if (sameName(name, n.name)) return n.expression;
  return nullptr;
}

constexpr std::string_view kPrefix = "lpe:";

// Which lobes of stock materials have which number where the scene does not say (rib.md 4.3, Option "lpe").
struct Numbered {
  const char* option;
  const char* lobes;
};
constexpr Numbered kNumbered[] = {
    {"diffuse2", "Diffuse,HairDiffuse,diffuse,translucent,hair4,irradiance"},
    {"diffuse3", "Subsurface,subsurface"},
    {"diffuse4", ""},
    {"specular2", "Specular,HairSpecularR,specular,hair1"},
    {"specular3", "RoughSpecular,HairSpecularTRT,hair3"},
    {"specular4", "Clearcoat"},
    {"specular5", "Iridescence"},
    {"specular6", "Fuzz,HairSpecularGLINTS"},
    {"specular7", "SingleScatter,HairSpecularTT,hair2"},
    {"specular8", "Glass,specular"},
};

}  // namespace

LobeNumbers::LobeNumbers(const scene::ParameterList& options) {
  for (const Numbered& n : kNumbered) {
    const std::string option = n.option;
    const bool isDiffuse = option.starts_with("diffuse");
    const int lobe = (isDiffuse ? 0 : kFirstSpecularLobe) + (option.back() - '1');
    std::string name;
    for (const char c : options.getString("lpe:" + option, n.lobes) + ",") {
      if (c != ',' && !std::isspace(static_cast<unsigned char>(c)))
        name += c;
      else if (!name.empty())
        (isDiffuse ? diffuse_ : specular_).try_emplace(std::exchange(name, {}), lobe);  // the first list counts
    }
  }
}

int LobeNumbers::of(bool isSpecular, std::string_view lobe) const {
  const auto& list = isSpecular ? specular_ : diffuse_;
  const auto it = list.find(lobe);
  return it != list.end() ? it->second : isSpecular ? kFirstSpecularLobe : 0;
}

bool LightPaths::knows(std::string_view source) {
  return source.starts_with(kPrefix) || namedExpression(source) != nullptr;
}

std::optional<PathExpression> LightPaths::parse(std::string_view source, PathSyntaxError& error) {
  size_t before = 0;
  if (source.starts_with(kPrefix)) source.remove_prefix(before = kPrefix.size());
  if (const char* expression = namedExpression(source)) return parsePathExpression(expression, error);
  std::optional<PathExpression> e = parsePathExpression(source, error);
  error.column += before;
  return e;
}

LightPaths::LightPaths(const std::vector<std::string>& sources, bool needSplit, LobeNumbers lobes, bool hasLightStage)
    : lobes_(std::move(lobes)), lights_(sources.size(), PathLight::AsItArrives), userLobes_(sources.size(), 0) {
  std::vector<PathExpression> list;
  std::vector<uint16_t> sourceOf;
  for (size_t i = 0; i < sources.size(); ++i) {
    if (!knows(sources[i])) continue;
    PathSyntaxError ignored;
    std::optional<PathExpression> e = parse(sources[i], ignored);
    if (!e) continue;  // told by display_channels.cpp, which puts kVisibleFallback in its place
    if (e->flags.unoccluded) lights_[i] = PathLight::Unoccluded;
    if (e->flags.shadows) lights_[i] = PathLight::Blocked;
    list.push_back(std::move(*e));
    sourceOf.push_back(uint16_t(i));
  }
  for (int tries = 0; !automaton_.build(list, needSplit); ++tries) {
    // what the scene says last is the likeliest to be too much
    isTooLarge_ = true;
    for (size_t drop = tries < 8 ? 1 : list.size() / 2 + 1; drop; --drop) {
      unmatched_.push_back(sourceOf.back());
      list.pop_back();
      sourceOf.pop_back();
    }
    automaton_ = PathAutomaton();
  }
  for (size_t i = 0; i < list.size(); ++i) {
    userLobes_[sourceOf[i]] = automaton_.userLobes(i);
    if (!automaton_.matches(i)) unmatched_.push_back(sourceOf[i]);
  }
  if (hasLightStage) tails_ = PathTails(automaton_);
  outputs_.resize(size_t(stateCount()) * ends());
  for (uint32_t s = 0; s < stateCount(); ++s)
    for (uint32_t e = 0; e < ends(); ++e)
      for (const uint16_t i : automaton_.accepted(s, e)) outputs_[s * ends() + e].push_back(sourceOf[i]);
}

int LightPaths::labelOf(std::string_view text) const {
  const auto& labels = automaton_.labels();
  const auto it = std::find(labels.begin(), labels.end(), text);
  return it == labels.end() ? -1 : int(it - labels.begin());
}

bool LightPaths::usesSurface(std::string_view group) const { return labelOf(group) >= 0; }

uint16_t LightPaths::event(uint32_t lobeFlags, std::string_view lobe, std::string_view surface) const {
  const bool isSpecular = lobeFlags & kLobeSpecular;
  const uint8_t type = lobeFlags & kLobeVolume     ? kPathVolume
                       : lobeFlags & kLobeTransmit ? kPathTransmit
                                                   : kPathReflect;
  return uint16_t(automaton_.event(type, lobes_.of(isSpecular, lobe), labelOf(surface), labelOf(lobe)));
}

uint16_t LightPaths::end(std::string_view lightGroup) const {
  const auto& groups = automaton_.lightGroups();
  const auto it = std::find(groups.begin(), groups.end(), lightGroup);
  return uint16_t(it == groups.end() ? 1 : 2 + (it - groups.begin()));
}

const std::vector<uint16_t>& LightPaths::outputs(uint32_t state, uint32_t end) const {
  return outputs_[state * ends() + end];
}

// Only light that some surface sent on can have been shadowed.
bool LightPaths::wantsUnshadowed() const {
  for (uint32_t s = 0; s < stateCount(); ++s)
    for (uint32_t e = 1; e < ends() && s != automaton_.start(); ++e)
      for (const uint16_t i : outputs_[s * ends() + e])
        if (lights_[i] != PathLight::AsItArrives) return true;
  return false;
}

}  // namespace kinora::film
