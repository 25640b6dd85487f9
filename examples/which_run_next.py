# %% [markdown]
# # Which run next?
#
# A stiffening gas spring or an end stop: on gentle roads the two look alike. Which road and duty would tell them apart,
# within what the rig can do?

# %%
import er_model_lab as lab

car = lab.load_model("inove_quarter_car")
plan = lab.plan(car, between=("gas_spring", "end_stop"), duration=10.0, seed=1)
print(plan)

# %% [markdown]
# The plan says what to run, why it decides, and how often the lab names the truth on simulated measurements of it.

# %%
for sentence in plan.to_dict()["why"]:
    print(sentence)
print(plan.to_frame())

# %% [markdown]
# The program is a file for the plant node or for a rig: `save_program(plan.program, "next.yaml")`.

# %%
assert plan.program is not None
print(plan.program.name, plan.program.duration, "s")
