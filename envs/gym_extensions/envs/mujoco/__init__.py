"""The MuJoCo environments: models, bodies with their rules, and many of them stepped together."""
