// A shader of the shading language as a pattern node: described like a plug-in, so that parameters, references and
// messages are those of every other node. Made by ShaderLibrary.
#pragma once
#include <kinora/plugin.h>

#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "base/diagnostics.h"
#include "language/program/program.h"
#include "scene/scene.h"

namespace kinora::shade {

// One shader. Its descriptor has no functions: shader_groups.h runs it.
struct ShaderNode {
  std::shared_ptr<const language::Shader> shader;  // null: the file is there and cannot be compiled
  std::string file;
  Descriptor descriptor{};
  std::vector<Param> params;                 // of the descriptor; structs have a parameter for each field, "s.field"
  std::vector<language::SymbolId> symbolOf;  // by parameter
  bool asksRayType = false;                  // calls raytype()
  std::deque<std::string> texts;
  std::deque<std::vector<float>> lists;
};

// Which shader a node of a scene means: PxrOSL names its shader, any other name may be a shader's own.
std::string shaderNameOf(const scene::Node& node);

// `shader`: null for a file that cannot be compiled.
std::shared_ptr<const ShaderNode> makeShaderNode(const std::string& file, std::shared_ptr<language::Shader> shader);

// The shader with what it leaves in P as an output kMovedPoint, and what it leaves in N, where it writes that, as
// kMovedNormal; null where it writes neither.
inline constexpr const char *kMovedPoint = "__movedP", *kMovedNormal = "__movedN";
std::shared_ptr<const ShaderNode> withMovedPoint(const ShaderNode& node);

}  // namespace kinora::shade
