//! What the files here use.

pub(crate) use std::collections::{BTreeMap, BTreeSet};
pub(crate) use std::fs;
pub(crate) use std::path::{Path, PathBuf};
pub(crate) use std::process::{Command, Stdio};
pub(crate) use std::time::Instant;

pub(crate) use anyhow::{Context, Result, anyhow, bail, ensure};
pub(crate) use clap::Args;
pub(crate) use memchr::memmem;
pub(crate) use object::Object;
pub(crate) use regex_lite::{Captures, Regex};
pub(crate) use serde_json::Value;
pub(crate) use xshell::{Cmd, PushEnv};

pub(crate) use crate::car::CRASH;
pub(crate) use crate::declarations::{self, Form, HEADERS, INCLUDE, Item};
pub(crate) use crate::files::*;
pub(crate) use crate::install::{self, Built, FULL, Flavour, SLIM};
pub(crate) use crate::native::{self, Build};
pub(crate) use crate::package::manifest::sha256;
pub(crate) use crate::package::{self, CLIENT, archive, licenses, markdown, nothing_of_this_machine};
pub(crate) use crate::stage::{self, LeftOut, Rules, Stage, all_passed, stages, unless};
pub(crate) use crate::target::*;
pub(crate) use crate::tools::{self, *};
pub(crate) use crate::wine::{self, Display, Wine};
pub(crate) use crate::workspace::*;
pub(crate) use crate::{
    abi, blender, car, command, csharp, debian, exports, fuzz, godot, header, lab, nightly, platforms, python,
    reference, repo, rooms, source, valgrind, vulkan, web,
};
