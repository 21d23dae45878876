// Rows of the superior tree.
#include "table.h"
