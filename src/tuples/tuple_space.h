#pragma once

#include "base/scheduler.h"
#include "rubicon/tuple_space.hpp"
#include "tuples/link.h"
