// Runs the built program as a user does and keeps what it printed. Used by the tests of this folder. Each Workplace
// is a folder of its own in the temporary directory, removed with it.
#pragma once
#include <csignal>
#include <functional>
#include <string>
#include <vector>

namespace kinora::cli {

struct Result {
  int exitCode = -1;  // -1: did not end by itself
  int signal = 0;     // that ended it
  bool isTimedOut = false;
  std::string out, err;
};

struct RunOptions {
  std::string input;                     // standard input
  std::vector<std::string> environment;  // "NAME=VALUE", besides the test's own
  uint64_t fileSizeLimit = 0;            // bytes a file may have, as on a full disk; 0: none
  uint64_t addressSpaceLimit = 0;        // bytes of memory; 0: none
  int timeoutSeconds = 120;
  // Called with what standard output holds so far, each time it grows; true sends SIGTERM, once.
  std::function<bool(const std::string&)> terminateWhen;
  int signal = SIGTERM;            // what terminateWhen and signalAfterSeconds send
  double signalAfterSeconds = -1;  // after the start; -1: never
  bool fromFirstOutput = false;    // ... after the first byte on standard output
};

class Workplace {
 public:
  Workplace();
  ~Workplace();
  Workplace(const Workplace&) = delete;
  Workplace& operator=(const Workplace&) = delete;

  // Runs `kinora arguments...` in the folder.
  Result run(const std::vector<std::string>& arguments, const RunOptions& options = {}) const;
  // Writes a file and returns its name.
  std::string write(const std::string& name, const std::string& text) const;
  std::string path(const std::string& name) const { return folder_ + "/" + name; }
  bool has(const std::string& name) const;
  std::vector<std::string> files() const;  // names, sorted

 private:
  std::string folder_;
};

// Whether two pictures are: `kinora diff` says so of every bit. A failure where it finds more than its usual limits.
bool areSame(const Workplace& w, const std::string& a, const std::string& b);

// What a test scene is made of. Small: a frame takes a fraction of a second.
struct SceneParts {
  std::string options;  // before the camera
  std::string display = "Display \"out.exr\" \"openexr\" \"rgba\"";
  std::string format = "Format 32 24 1";
  std::string samples = "Hider \"raytrace\" \"int maxsamples\" [4] \"int minsamples\" [4]";
  std::string camera = "Projection \"perspective\" \"fov\" [40]\nTranslate 0 0 4";
  std::string light =
      "AttributeBegin ConcatTransform [2 0 0 0  0 0 2 0  0 -1 0 0  0 3 0 1] Light \"PxrRectLight\" \"key\" "
      "\"float intensity\" [5] AttributeEnd";
  std::string material = "Bxdf \"PxrDiffuse\" \"matt\" \"color diffuseColor\" [0.5 0.4 0.3]";
  std::string geometry = "Sphere 1 -1 1 360";
};
std::string rib(const SceneParts& parts = {});

}  // namespace kinora::cli
