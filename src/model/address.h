#pragma once

#include "rubicon/address.hpp"
