// Shaders by name, kept from one world to the next: found along a search path, compiled in memory, compiled again
// when one of their files has changed. Owned by render's WorldBuilder, used by MaterialSet.
#pragma once
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "base/diagnostics.h"
#include "base/file_contents.h"
#include "language/vm/executable.h"
#include "shade/shader_node.h"

namespace kinora::shade {

class ShaderLibrary {
 public:
  // contents: what shaders compute is noted there; it outlives the library.
  explicit ShaderLibrary(Diagnostics& diagnostics, FileContents* contents = nullptr)
      : diagnostics_(diagnostics), contents_(contents) {}
  // Before each world: files are looked at again when they are next asked for. keepCompiled: what is compiled is
  // written beside its source too, as NAME.oso.
  void begin(std::vector<std::string> searchPath, bool keepCompiled);
  // NAME, NAME.osl or NAME.oso, absolute or along the path; .osl before .oso, but for an .oso that is newer. Null:
  // there is no such file; nothing was said. A file that cannot be compiled is told once for each state that it has.
  std::shared_ptr<const ShaderNode> find(const std::string& name, const SourcePos& pos);
  // A shader that is no file's: of a node's expression, or built in. Equal sources are one shader.
  std::shared_ptr<const ShaderNode> fromSource(const std::string& source, const std::string& name);
  // What an expression that has no source stands for: a shader that cannot be compiled, told once for each text.
  std::shared_ptr<const ShaderNode> refused(const std::string& expression, const std::string& problem,
                                            const SourcePos& pos);
  // withMovedPoint() of a shader, made once.
  std::shared_ptr<const ShaderNode> displacementOf(const std::shared_ptr<const ShaderNode>& node);
  language::ExecutableCache& executables() { return executables_; }
  // Over the life of the library.
  uint64_t compiled() const { return compiled_; }
  double compileSeconds() const { return compileSeconds_; }
  void addCompileSeconds(double s) { compileSeconds_ += s; }  // of groups

 private:
  // What a file was when it was read. A file written again within its clock's tick has the same time: then the text
  // decides.
  struct Stamp {
    std::string path;
    int64_t time = 0;
    uint64_t size = 0, textHash = 0;
    bool isYoung = true;
  };
  struct File {
    std::shared_ptr<const ShaderNode> node;
    std::vector<Stamp> stamps;  // the file's own first
    std::string wrong;          // why it cannot be compiled
    Digest program;             // of the code, whatever its text looks like and wherever it was compiled
    uint64_t lookedAt = 0;      // generation
  };
  struct Text {
    std::shared_ptr<const ShaderNode> node;
    uint64_t usedAt = 0;  // generation
  };
  static Stamp stampOf(const std::string& path);
  static bool isAsBefore(Stamp& stamp);
  std::string choose(const std::string& base) const;
  std::shared_ptr<const ShaderNode> open(const std::string& path, const SourcePos& pos);
  std::shared_ptr<language::Shader> read(const std::string& path, File& file);
  void writeBeside(const std::string& path, const language::Shader& shader, const File& file, const SourcePos& pos);

  Diagnostics& diagnostics_;
  FileContents* contents_;
  std::vector<std::string> searchPath_;
  bool keepCompiled_ = false;
  uint64_t generation_ = 0, compiled_ = 0;
  double compileSeconds_ = 0;
  std::map<std::string, std::shared_ptr<const ShaderNode>> byName_;  // of this generation
  std::map<std::string, Text> texts_;                                // by source, or by an expression that has none
  std::map<std::string, File> files_;                                // by path
  std::map<std::shared_ptr<const ShaderNode>, std::shared_ptr<const ShaderNode>> displacements_;  // of shaders
  language::ExecutableCache executables_;
};

}  // namespace kinora::shade
