#pragma once
// CLIPS for our own sources, and the parts of its interface that clips.h leaves out.

#include <clips_ns/clips.h>

namespace clips {
extern "C" {
// tmpltutl.h: the deftemplate of ordered facts `(name ...)`, made when there is none.
Deftemplate* CreateImpliedDeftemplate(Environment*, CLIPSLexeme*, bool);
}
}  // namespace clips
