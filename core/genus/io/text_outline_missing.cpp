// Stands in for text_outline.cpp where the libraries it needs were not found.

#include "genus/base/error.h"
#include "genus/io/text_outline.h"

namespace genus {

TextOutline text_outline(const TextOptions&)
{
    throw InvalidInput("text: needs FreeType and HarfBuzz, and genus was built without them");
}

}  // namespace genus
