// Where RIB bytes come from: a file or standard input (gzip found by its magic), a member of a zip archive, or
// memory. Used by the lexer alone. It knows nothing of RIB.
#pragma once
#include <cstddef>
#include <memory>
#include <string>

namespace kinora::rib {

class ByteSource {
 public:
  virtual ~ByteSource() = default;
  // Up to `size` bytes; 0 at the end and after a failure.
  virtual size_t read(char* to, size_t size) = 0;
  // Why reading stopped early ("unexpected end of gzip data"); "" when it did not.
  virtual std::string failure() const { return {}; }
};

// Null and a reason when `path` cannot be read ("is a directory", "No such file or directory"). "-" is standard
// input; "archive.zip!member" is a member of a zip archive.
std::unique_ptr<ByteSource> openFile(const std::string& path, std::string& why);
// What to open for a file of the command line: itself, or the scene in it where it is a zip archive: the only RIB
// file, or the one named like the archive, or that has a world, or that stands above all others. "" and a reason when
// no or no one member is that.
std::string sceneIn(const std::string& path, std::string& why);
std::unique_ptr<ByteSource> openText(std::string text);
// True for what a scene may name as an archive: a regular file, or a zip archive with a member part.
bool isReadable(const std::string& path);

}  // namespace kinora::rib
