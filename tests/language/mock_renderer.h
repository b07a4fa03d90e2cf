// A renderer whose answers are formulas, for programs that ask one. At the point with parameters u and v:
//   spaces      "object" is common scaled by (2, 4, 8), "shader" common moved by (1, 2, 3), "camera" common turned by
//   90
//               degrees about z ((1,0,0) becomes (0,1,0)), "moving" common moved by (u, 0, 0): to common, all of them
//   attributes  int "flag" 7, float "gain" 2.5, color/point/vector/normal "tint" (.25,.5,.75), string "label" "mock",
//               float "where" u, float[2] "pair" {1,2}, matrix "frame" 2; of object "other" float "gain" 3.5; float
//               "list" with index i: 10 i + .5, also of object "other": + 100
//   texture     component k of (s, t): s + 10 t + 100 k + 1000 fill + 2000 width + 4000 blur, with derivatives along
//   s and
//               t; "alpha" 0.5, "errormessage" ""; a file "missing" gives -1 and the message "no file"
//   texture3d, environment   x + 10 y + 100 z + 1000 k + the same options
//   gettextureinfo  "exists" 1 (of "missing": 0), "channels" 3, "resolution" {64, 32}, "type" "Plain Texture",
//               "averagecolor" (.1,.2,.3), "averagealpha" .5; with s and t: "channels" 4
//   raytype     "camera" 1; backfacing v > .5; surfacearea 2 + u
//   trace       1 where the position's z is below "maxdist" (1 unless given); message "hitdist" of "trace": 4 (float)
#pragma once
#include <string>
#include <vector>

#include "language/library/dictionary.h"
#include "language/vm/services.h"

namespace kinora::oracle {

struct MockRenderer {
  struct Message {
    language::MessageKind kind;
    std::string text, file;
    friend bool operator==(const Message&, const Message&) = default;
  };
  std::vector<Message> messages;
  float shiftU = 0, shiftV = 0;  // of the points
  language::Dictionary dictionary;
  language::RendererServices services();
};

}  // namespace kinora::oracle
