// Materials and the shading programs they share. A program is a bxdf and the structure of the pattern network that
// feeds it; materials that differ only in parameter values are instances of one program, with their numbers in a
// block each. Built by render/ from the scene's networks; read by contexts.
#pragma once
#include <kinora/bxdf.h>
#include <kinora/displacement.h>
#include <kinora/pattern.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "base/diagnostics.h"
#include "film/light_paths.h"
#include "plugin/registry.h"
#include "scene/scene.h"
#include "shade/no_effect.h"
#include "shade/shader_groups.h"
#include "shade/shader_library.h"

namespace kinora {
class TextureSystem;
namespace shade {

// Where a node's parameter comes from.
struct ParamSource {
  enum class From : uint8_t { Constant, Gathered, Connected } from = From::Constant;
  uint8_t components = 1;
  bool given = false;             // the scene sets it (all materials of the program alike)
  uint32_t offset = 0;            // Gathered: floats into the material's block
  uint32_t node = 0, output = 0;  // Connected: producer and its output (index among the outputs)
  int32_t part = -1;              // Connected: one element or component of it; -1: the whole
  float constant[3] = {0, 0, 0};
  const char* text = "";      // strings
  std::vector<float> list;    // arrays
  std::vector<int32_t> ints;  // of shaders: arrays of integers, of strings
  std::vector<std::string> strings;
};

// An element of an array or a component of a parameter of a shader that another shader feeds.
struct PartSource {
  uint32_t param = 0;
  int32_t part = 0;
  uint32_t node = 0, output = 0;
  int32_t fromPart = -1;
};

struct ProgramNode {
  const Descriptor* plugin = nullptr;
  std::shared_ptr<const ShaderNode> source;  // a shader, which has no functions; null: a plug-in
  int32_t shader = -1;                       // index into Program::shaders; -1: none, or it cannot run
  std::string handle;
  SourcePos pos;                    // of the first material's
  std::vector<ParamSource> params;  // by declared parameter
  std::vector<PartSource> parts;
  std::vector<uint32_t> outputParam;  // output index -> parameter index
  std::vector<uint8_t> wanted;        // by output: what somebody reads of it (Want)
};

struct Program {
  std::vector<ProgramNode> nodes;       // producers first; the last one is the bxdf, or the displacement
  const BxdfFunctions* bxdf = nullptr;  // for the width in use
  const DisplacementFunctions* displacement = nullptr;
  bool isMovedByShader = false;  // the last node reads where a shader has moved its point to
  std::vector<const PatternFunctions*> patterns;
  std::vector<ShaderUse> shaders;
  const BxdfTraits* traits = nullptr;
  std::vector<std::string> texts;  // owns the strings
  struct Tee {
    std::string channel;
    uint32_t node, output;
  };
  std::vector<Tee> tees;  // what PxrTee nodes that name a channel and PxrMatteID nodes show
  uint32_t blockFloats = 0;
  std::vector<float> blocks;  // materials' blocks, one after the other
  uint32_t materials = 0;
  bool opaque = true;          // presence is 1 everywhere
  bool encloses = false;       // paths that go in keep a medium
  bool scatters = false;       // paths may go below its surfaces
  bool tints = false;          // tinted shadows pass
  int32_t shadowColor = -1;    // parameter of the bxdf: share of the light left in shadows that it casts; -1: none is
  bool fillsSpace = false;     // a medium: its objects have no surface
  bool isFiber = false;        // on curves rays leave from behind as well, see kBxdfFiber
  uint32_t walkableLobes = 0;  // manifold walks go through its surfaces by these
  uint32_t mediumFlags = 0;
  uint32_t slotCount = 1;
  std::string lpeGroup;  // of its objects, where expressions tell it apart
  std::vector<uint8_t> slotOfLobe;
  std::vector<uint16_t> eventOfSlot;
  uint32_t tintedSlots = 0, walkableSlots = 0;
};

struct Material {
  uint32_t program = 0, block = 0;
};

class MaterialSet {
 public:
  // `paths`: tells events of lobes apart, and by them the slots that bxdfs sum into. It must outlive the set,
  // `shaders` until finish().
  MaterialSet(Registry& registry, Diagnostics& diagnostics, TextureSystem& textures, uint32_t width,
              const film::LightPaths& paths, ShaderLibrary& shaders);
  // Index of the material of a network with its attributes; null network: a plain diffuse of the Color attribute.
  uint32_t add(const scene::NetworkPtr& network, const scene::Attributes* attributes, const SourcePos& pos);
  // Of a network whose terminal is a displacement. kNone where that moves nothing and, after a message, where there is
  // none of that name.
  static constexpr uint32_t kNone = ~0u;
  uint32_t addDisplacement(const scene::NetworkPtr& network);
  // After the last add: finds what is uniform, and the slots that light path expressions tell apart.
  void finish();

  const Material& operator[](uint32_t i) const { return materials_[i]; }
  const Program& program(uint32_t i) const { return *programs_[i]; }
  uint32_t programCount() const { return uint32_t(programs_.size()); }
  uint32_t size() const { return uint32_t(materials_.size()); }
  bool opaque(uint32_t material) const { return programs_[materials_[material].program]->opaque; }
  bool encloses(uint32_t material) const { return programs_[materials_[material].program]->encloses; }
  bool tints(uint32_t material) const { return programs_[materials_[material].program]->tints; }
  bool colorsShadows(uint32_t material) const { return programs_[materials_[material].program]->shadowColor >= 0; }
  bool isWalkable(uint32_t material) const { return programs_[materials_[material].program]->walkableLobes != 0; }
  bool fillsSpace(uint32_t material) const { return programs_[materials_[material].program]->fillsSpace; }
  // Of materials that fill space.
  struct Extinction {
    bool isProduct = false;  // else it is known by shading only
    float factor[3] = {1, 1, 1}, most = -1, towardsLights = 0.5f, extinctionByBounce = 1, contributionByBounce = 1,
          velocityFactor = 1, constantVelocity[3] = {0, 0, 0};
    std::string number, color, velocity;  // see ExtinctionProduct; "": 1, and none
  };
  const Extinction& extinction(uint32_t material) const { return extinctions_.at(material); }
  uint64_t bytes() const;
  uint64_t shaderBytes() const;  // of programs of the shading language
  const std::vector<const ShaderUse*>& shaderUses() const { return shaderUses_; }  // by ShaderUse::number
  uint32_t materialsOf(const ShaderUse& use) const { return materialsOfUse_[use.number]; }
  uint32_t width() const { return width_; }

 private:
  struct Resolved;  // a node with its values
  struct ShadowsCast {
    int32_t color = -1;       // the parameter, where it may be other than black
    bool isColorAll = false;  // nothing else passes: no tint of glass
  };
  bool resolve(const scene::Node& node, Kind kind, Resolved& out);
  uint32_t addResolved(std::vector<Resolved>& nodes, const std::string& lpeGroup);
  struct Handles;  // of a network's patterns
  void addPatterns(const scene::Network& network, std::vector<Resolved>& nodes, Handles& handles);
  void connect(std::vector<Resolved>& nodes, const Handles& handles);
  // rules_by_name.cpp
  static void connectMembers(std::vector<Resolved>& nodes, Resolved& to, uint32_t parameter);
  static ShadowsCast shadowsCast(const Resolved& bxdf);
  static void switchOffEmpty(Resolved& r);
  Registry& registry_;
  Diagnostics& diagnostics_;
  TextureSystem& textures_;
  uint32_t width_;
  const film::LightPaths& paths_;
  ShaderLibrary& shaders_;
  std::vector<Material> materials_;
  std::map<uint32_t, Extinction> extinctions_;  // by material
  std::vector<std::unique_ptr<Program>> programs_;
  std::vector<const ShaderUse*> shaderUses_;
  std::vector<uint32_t> materialsOfUse_;
  std::map<std::string, uint32_t> programOfKey_;
  std::map<std::pair<const void*, std::string>, uint32_t> known_;
  std::map<const void*, scene::NetworkPtr> keepAlive_;
  NoEffect noEffect_;
};

// Values of a node for Descriptor::create (lights, integrators, projections, displays): defaults filled in, unknown
// parameters reported. The storage lives as long as this object.
class ResolvedParams {
 public:
  ResolvedParams(const Descriptor& plugin, const scene::Node* node, Diagnostics& diagnostics);
  const ParamValue* values() const { return values_.data(); }
  uint32_t count() const { return uint32_t(values_.size()); }
  bool given(uint32_t i) const { return values_[i].given; }
  // Given texts, and what a connected parameter is connected to: an array to as many outputs as the scene names.
  const std::vector<std::string>& texts(uint32_t i) const { return strings_[i]; }
  // Given integers as they are; values() has them as floats.
  const std::vector<int>& ints(uint32_t i) const { return ints_[i]; }
  // A pattern feeds the parameter after all; its value becomes another node's.
  void connect(uint32_t i) { values_[i].connected = values_[i].given = 1; }
  // Instead of a connection that brings nothing.
  void setColor(uint32_t i, float r, float g, float b) {
    floats_[i] = {r, g, b};
    values_[i].floats = floats_[i].data(), values_[i].count = 3, values_[i].connected = 0;
  }
  void setNumber(uint32_t i, float v) {
    floats_[i].assign(1, v), values_[i].floats = floats_[i].data(), values_[i].count = 1;
  }

 private:
  std::vector<ParamValue> values_;
  std::vector<std::vector<float>> floats_;
  std::vector<std::vector<int>> ints_;
  std::vector<std::vector<std::string>> strings_;
  std::vector<std::vector<const char*>> pointers_;
};

}  // namespace shade
}  // namespace kinora
