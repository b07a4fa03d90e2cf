// Pattern nodes that the renderer runs as shaders although they come with it: PxrSeExpr, whose expression is translated,
// and those that ask for what only shaders reach. Their plug-ins hold parameters, help and a visible stand-in for hosts
// without a shading language. Used by MaterialSet.
#pragma once
#include <memory>
#include <optional>

#include "base/diagnostics.h"
#include "scene/scene.h"
#include "shade/shader_library.h"

namespace kinora::shade {

struct StandardShader {
  std::shared_ptr<const ShaderNode> shader;
  scene::Node node;  // with the parameters as the shader names them
};
// Nothing for nodes of other plug-ins.
std::optional<StandardShader> standardShader(const scene::Node& node, ShaderLibrary& library);

}  // namespace kinora::shade
