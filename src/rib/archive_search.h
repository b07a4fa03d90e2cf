// Where the file of an archive is: search path, folders of the files that name it, paths of other machines. Used by
// the interpreter and by convert.cpp. It opens files only to see whether they are there.
#pragma once
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace kinora::rib {

using Dirmap = std::vector<std::pair<std::string, std::string>>;  // FROM, TO

// The first FROM that the name begins with gives way to its TO. FROM ends at a whole part of the path: "/a" maps
// "/a/b" and leaves "/ab" alone.
std::string mapDirectory(const std::string& name, const Dirmap& map);

// Option "searchpath" "dirmap": ["ZONE" "FROM" "TO"] any number of times. A zone is a kind of machine: NFS is this
// one, entries of others (UNC) count where their TO is a folder here. False when it reads otherwise.
bool readDirmap(const std::string& text, Dirmap& out);

// The parts of a scene's own path ("dir:@:dir2"); '@' is `standard`, which also follows at the end.
// $NAME and ${NAME} in it are variables of the environment; those that are not set stay.
std::string withEnvironment(const std::string& path);
std::vector<std::string> expandSearchPath(const std::string& own, const std::vector<std::string>& standard);

// The folder of a file, with its slash, "" for the current one; of a member of a zip archive that of the archive.
std::string folderOf(const std::string& file);

struct ArchiveSearch {
  std::vector<std::string> path;
  Dirmap dirmap;
  std::string mainDirectory;  // of the main file, with its slash; "" for the current one
  // As named; beside the file that names it, inside its zip archive and beside that; beside the main file; along the
  // path; in the folders above the main file; then its base name beside these files and along the path, for paths of
  // another machine. "" when it is nowhere.
  std::string find(const std::string& asNamed, const std::string& including) const;
};

}  // namespace kinora::rib
