// What a scene gives to the parameters of a shader, brought to the form of plug-ins: declared types are checked,
// structs are taken apart into their fields, arrays get their full length. Used by MaterialSet.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "base/diagnostics.h"
#include "scene/scene.h"
#include "shade/shader_node.h"

namespace kinora::shade {

// An element of an array or a component of a triple or matrix that is fed by itself: "reference color c[1]"
// ["handle:output"], or one of the references of an array, "reference float[3] a" ["p:r" "" "q:r"].
struct PartReference {
  uint32_t parameter = 0;
  int32_t part = 0;
  std::string from;
};

// The node with parameters that ResolvedParams takes; what cannot be used is told and left out.
scene::Node forShader(const scene::Node& node, const ShaderNode& shader, std::vector<PartReference>& parts,
                      Diagnostics& diagnostics);

// The node of a plug-in that declares NAME_0, NAME_1 ... beside an array NAME: references to the array's elements become
// references of those, and the array keeps its length. Nothing where there are none.
std::optional<scene::Node> withElements(const scene::Node& node, const Descriptor& plugin, Diagnostics& diagnostics);

// "name[3]" -> name and 3; -1 where there is no index.
int32_t splitIndex(std::string& name);

// "" or why an output may not feed a parameter. Between shaders by the rules of OSL; plug-ins convert numbers and
// triples into each other. An index makes an element of an array, a number of a triple or matrix.
std::string connectionProblem(const Param& from, bool fromShader, int32_t fromPart, const Param& to, bool toShader,
                              int32_t toPart);

}  // namespace kinora::shade
