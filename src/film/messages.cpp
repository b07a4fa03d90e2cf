#include "film/messages.h"

namespace kinora::film {

namespace {

constexpr Explanation kExplanations[] = {
    {"DISPLAY-FOLDER",
     "With -o, further pictures of the scene whose folder does not exist here are written beside the first one, "
     "under their "
     "own names."},
    {"LPE-SYNTAX",
     "A light path expression (\"lpe:...\" as the source of a DisplayChannel) is malformed; the message shows where. "
     "The "
     "channel is magenta. An expression begins with C, the camera, and ends with L, a light, or O, a glowing "
     "surface or a light that the camera sees itself; "
     "between stand events: D, S, <RD>, <T[DS]>, <.S'label'>, D2, <L.'group'>, <RD[^'label']>, sets [...], and the "
     "operators | * + ? {n,m} ( ). Before all that may stand unoccluded; (light as if nothing were in its way) or "
     "shadows; (what shadows take of it): both are made of light samples alone, and very noisy on glossy surfaces."},
    {"LPE-",
     "A light path expression is read but cannot be had as it is written: it matches no path, is too large, asks for "
     "what is not told apart. The message says what the channel holds. A light that the camera sees itself is O, "
     "like a "
     "glowing surface, and not L: \"C<L.>\" takes no path, \"CO\" or \"C[<L.>O]\" does, and what sums L and O counts "
     "each "
     "light once. The group of a light stands behind either: \"C.*[<L.'key'><O.'key'>]\"."},
    {"DISPLAY-DRIVER",
     "A Display names a driver that is no plug-in, or a program that shows pictures in a window (framebuffer, it). "
     "The "
     "format is chosen by the file's extension, or openexr stands in."},
    {"DISPLAY-ID",
     "A channel shows identifiers (identifier:id or id2), and some object has one that is negative or has more than "
     "24 "
     "bits. Pictures hold them as floats, so that neighbouring identifiers of that size become one. Number objects "
     "from 0 "
     "to 16,777,216."},
    {"DISPLAY-CAMERA",
     "A display's \"string camera\" names the Camera request whose picture it shows; a frame whose displays name "
     "several is rendered once for each. The message says that there is no camera of that name, or that one run can "
     "give one of them only: --only-sample, and a part (--samples) with a name by -o, are of one picture."},
    {"DISPLAY-SAME-FILE",
     "Two displays of a frame, or a display and -o, name one file, and the second picture would take the place of "
     "the "
     "first. Nothing is rendered. Name a file for each; one display holds any number of channels: "
     "\"Ci,a,z,diffuse\". A "
     "display that shows a window (framebuffer, it) beside a file of its name is not meant: one picture is written."},
    {"DISPLAY-WRITE", "A picture could not be written; the message gives the reason. Exit code 6."},
    {"DISPLAY-",
     "A Display or DisplayChannel asks for something that is not known or not rendered. The message names the "
     "display and "
     "says what is written instead; the other channels and displays are not affected."},
    {"DISPLAY-SNAPSHOT",
     "The picture so far could not be written in the middle of a render, mostly because the disk is full. The file "
     "is "
     "what it was before, the render goes on, and the next snapshot and the end try again."},
    {"FILM-MEMORY",
     "The picture with all its channels does not fit the memory. Exit code 5. Fewer channels need less."},
    {"FILM-FILTER", "The pixel filter is unknown or its width is not usable. gaussian 2 2 is used."},
    {"FILM-MERGE-OVERWRITE",
     "The picture that merge would write has the name of one of the parts, whose samples would be lost. Nothing is "
     "written; the exit code is 2. Give the picture another name with -o."},
    {"FILM-SHARD-SCENE",
     "A part of a frame is of another scene than the parts before it. The message names the first difference: the "
     "object with its file and line in both scenes, or the option, camera, light, texture, shader, volume or "
     "plug-in, "
     "and what of it differs. Files count by what they hold: copies in other folders and on other machines are the "
     "same file. Comments, the names of pictures, search paths, threads and the order of buckets do not count, "
     "the version of the program does. Nothing is merged. Render the part again from the scene of the others."},
    {"FILM-SHARD-",
     "A part of a frame (`kinora render --samples`) cannot be written, read or added: it is not a part, is broken, "
     "belongs "
     "to another scene, seed, frame or version, or holds samples that another part has too. Nothing is merged."},
    {"FILM-", "The film refused sizes or channels that cannot be summed; the message says which."},
};

}  // namespace

std::span<const Explanation> explanations() { return kExplanations; }

}  // namespace kinora::film
