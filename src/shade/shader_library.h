// Shading-language shaders as pattern nodes: found by name along a search path, compiled in memory, and described
// like a plug-in, so that parameters, references and messages are those of every other node. Used by MaterialSet.
#pragma once
#include <kinora/plugin.h>

#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "base/diagnostics.h"
#include "language/program/program.h"

namespace kinora::shade {

// One shader. Its descriptor has no functions: shader_groups.h runs it.
struct ShaderNode {
  std::shared_ptr<const language::Shader> shader;  // null: the file is there and cannot be compiled
  std::string file;
  Descriptor descriptor{};
  std::vector<Param> params;                 // of the descriptor; structs have a parameter for each field, "s.field"
  std::vector<language::SymbolId> symbolOf;  // by parameter
  std::deque<std::string> texts;
  std::deque<std::vector<float>> lists;
};

class ShaderLibrary {
 public:
  ShaderLibrary(std::vector<std::string> searchPath, Diagnostics& diagnostics)
      : searchPath_(std::move(searchPath)), diagnostics_(diagnostics) {}
  // NAME, NAME.osl or NAME.oso, absolute or along the path, .osl first. Null: there is no such file; nothing was
  // said. A file that cannot be compiled is told once.
  const ShaderNode* find(const std::string& name, const SourcePos& pos);

 private:
  std::unique_ptr<ShaderNode> load(const std::string& path, const SourcePos& pos);
  std::vector<std::string> searchPath_;
  Diagnostics& diagnostics_;
  std::map<std::string, std::unique_ptr<ShaderNode>> known_;  // by name
};

}  // namespace kinora::shade
